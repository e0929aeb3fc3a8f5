//! COCO object detection, <https://cocodataset.org/#format-data>: one JSON object. A box is left, top, width, height;
//! the first pixel is 0. The field `score` is from COCO's format of results, `track_id` from CVAT and Datumaro.

use super::{About, Answer, score};
use anyhow::Result;
use serde_json::json;

#[derive(Default)]
pub(super) struct Images {
    frames: Vec<usize>,
    size: (u16, u16),
    annotations: usize,
}

pub(super) fn head(about: &About) -> String {
    let category = |target| json!({"id": target + 1, "name": about.label(target), "supercategory": ""});
    let categories: Vec<_> = (0..about.targets.len()).map(category).collect();
    let info = json!({"description": about.name, "version": about.origin.version});
    format!("{{\"info\":{info},\n\"licenses\":[],\n\"categories\":{},\n\"annotations\":[", json!(categories))
}

impl Images {
    /// Returns an answer's annotation, after a comma if it is not the first; empty text if the target is not visible.
    pub fn annotation(&mut self, answer: &Answer<'_>) -> Result<String> {
        let &Answer { target, frame, size, report, .. } = answer;
        if self.frames.last() != Some(&frame) {
            self.frames.push(frame);
        }
        self.size = size;
        let Some((report, seen)) = report.and_then(|report| Some((report, report.target?))) else {
            return Ok(String::new());
        };
        let comma = if self.annotations == 0 { "" } else { "," };
        self.annotations += 1;
        let annotation = json!({
            "id": self.annotations,
            "image_id": frame,
            "category_id": target + 1,
            "bbox": [seen.x, seen.y, seen.width, seen.height],
            "area": seen.width * seen.height,
            "iscrowd": 0,
            "score": score(report),
            "track_id": target + 1,
        });
        Ok(format!("{comma}\n{annotation}"))
    }

    pub fn foot(&self, about: &About) -> Result<String> {
        let (width, height) = self.size;
        // CVAT names the frames of a video `frame_NNNNNN.png`, from 0.
        let name = |frame: usize| {
            about.images.get(frame - 1).cloned().unwrap_or_else(|| format!("frame_{:06}.png", frame - 1))
        };
        let image = |&frame| json!({"id": frame, "file_name": name(frame), "width": width, "height": height});
        let images: Vec<_> = self.frames.iter().map(image).collect();
        Ok(format!("\n],\n\"images\":{}}}\n", serde_json::to_string(&images)?))
    }
}
