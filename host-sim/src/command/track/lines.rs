//! The printed boxes: on standard output, or in a file.

use crate::command::is_closed_pipe;
use anyhow::Result;
use smr_files::output::{Output, print};
use std::io::Write;

/// Output of lines. Standard output gets each line at once, so an error loses none; a file appears only when complete.
pub enum Lines {
    /// Standard output. With `goes_on`, a closed pipe does not end the command, because a video is written, too.
    Printed {
        goes_on: bool,
    },
    File(Output),
    /// Text that is printed when the recording is done, and not at all after an error.
    Kept(String),
    Unread,
}

impl Lines {
    pub fn write(&mut self, text: &str) -> Result<()> {
        match self {
            Self::Printed { goes_on } => match print(|out| out.write_all(text.as_bytes())) {
                Err(error) if *goes_on && is_closed_pipe(&error) => *self = Self::Unread,
                printed => printed?,
            },
            Self::File(file) => file.write(text.as_bytes())?,
            Self::Kept(kept) => kept.push_str(text),
            Self::Unread => {}
        }
        Ok(())
    }

    pub fn settle(&mut self) -> Result<()> {
        if let Self::File(file) = self { file.settle() } else { Ok(()) }
    }

    /// Ends the output, and returns the text that is kept.
    pub fn finish(self) -> Result<String> {
        match self {
            Self::File(file) => file.finish().map(|()| String::new()),
            Self::Kept(kept) => Ok(kept),
            Self::Printed { .. } | Self::Unread => Ok(String::new()),
        }
    }
}
