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
            Self::Unread => {}
        }
        Ok(())
    }

    pub fn settle(&mut self) -> Result<()> {
        if let Self::File(file) = self { file.settle() } else { Ok(()) }
    }

    pub fn finish(self) -> Result<()> {
        if let Self::File(file) = self { file.finish() } else { Ok(()) }
    }
}
