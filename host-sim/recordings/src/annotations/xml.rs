//! Elements of an XML document, event by event. quick-xml knows XML; here are bounds, which make time and memory
//! linear in the size of any document, and errors with their lines.

use super::track::line_of;
use anyhow::{Result, anyhow, bail, ensure};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Error, Reader, XmlVersion};

/// CVAT nests four elements. An element farther inside is counted, but its attributes are not read.
const DEEPEST_READ: usize = 4;
const DEEPEST: usize = 64;
/// Largest number of attributes; a cuboid of CVAT has 24.
const MAX_ATTRIBUTES: usize = 64;

#[derive(Default)]
pub(super) struct Element {
    pub name: String,
    /// Position of the start tag in the text, in bytes.
    pub at: usize,
    attributes: Vec<(String, String)>,
}

impl Element {
    pub fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    fn read(tag: &BytesStart<'_>, at: usize) -> Result<Self, Error> {
        let read = tag.attributes().take(MAX_ATTRIBUTES + 1).map(|attribute| {
            let attribute = attribute?;
            let value = attribute.normalized_value(XmlVersion::Implicit1_0)?.into_owned();
            Ok((attribute.key.into_inner().to_owned(), value))
        });
        Ok(Self { name: tag.name().into_inner().to_owned(), at, attributes: read.collect::<Result<_, Error>>()? })
    }
}

pub(super) enum Step {
    Open(Element),
    Close,
}

pub(super) struct Steps<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    depth: usize,
    has_root: bool,
}

impl<'a> Steps<'a> {
    pub fn new(text: &'a str) -> Self {
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        Self { text, reader, depth: 0, has_root: false }
    }

    /// Returns the next start or end of an element; `None` at the end. Errors: The document is no XML, is cut short, has
    /// a DOCTYPE, or goes beyond a bound.
    pub fn next(&mut self) -> Result<Option<Step>> {
        loop {
            let at = usize::try_from(self.reader.buffer_position()).unwrap_or(usize::MAX);
            let line = || line_of(self.text, at);
            match self.reader.read_event().map_err(|error| self.damaged(&error))? {
                Event::Start(tag) => {
                    ensure!(self.depth > 0 || !self.has_root, "{}: a second document begins: expected one", line());
                    ensure!(self.depth < DEEPEST, "{}: its elements are nested too deep: expected CVAT XML", line());
                    (self.depth, self.has_root) = (self.depth + 1, true);
                    if self.depth > DEEPEST_READ {
                        return Ok(Some(Step::Open(Element::default())));
                    }
                    let element = Element::read(&tag, at).map_err(|error| damaged(self.text, at, &error))?;
                    let count = element.attributes.len();
                    ensure!(count <= MAX_ATTRIBUTES, "{}: <{}> has too many attributes", line(), element.name);
                    return Ok(Some(Step::Open(element)));
                }
                Event::End(_) => {
                    self.depth -= 1;
                    return Ok(Some(Step::Close));
                }
                Event::DocType(_) => bail!("{}: it has a DOCTYPE: expected CVAT XML, which has none", line()),
                Event::Eof if self.depth > 0 || !self.has_root => {
                    bail!("{}: it is cut short: {WHOLE}", line_of(self.text, self.text.trim_end().len()))
                }
                Event::Eof => return Ok(None),
                _ => {}
            }
        }
    }

    fn damaged(&self, error: &Error) -> anyhow::Error {
        damaged(self.text, usize::try_from(self.reader.error_position()).unwrap_or(usize::MAX), error)
    }
}

const WHOLE: &str = "expected a whole CVAT XML file";

fn damaged(text: &str, at: usize, error: &Error) -> anyhow::Error {
    let line = line_of(text, at);
    match error {
        Error::Syntax(_) => anyhow!("{line}: it is cut short: {WHOLE}"),
        _ => anyhow!("{line}: it is damaged ({error}): {WHOLE}"),
    }
}
