//! A line of the protocol as a message: `@@TRAX:name "argument" "key=value"`.
//!
//! Arguments are separated by spaces, and may be in double quotes. A backslash goes before a quote or a backslash that is meant as such, and
//! `\n` is a new line.

use anyhow::{Result, bail, ensure};

/// What every message begins with. Other lines are not for the protocol.
const PREFIX: &str = "@@TRAX:";

/// The most letters of a key.
const MOST_KEY: usize = 64;

/// A message: its name, its arguments in their order, and what is named.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Message {
    pub name: String,
    pub arguments: Vec<String>,
    pub properties: Vec<(String, String)>,
}

impl Message {
    /// A message that only has a name yet.
    pub fn new(name: &str) -> Self {
        Self { name: name.to_owned(), ..Self::default() }
    }

    /// The same with one more argument.
    pub fn argument(mut self, argument: impl Into<String>) -> Self {
        self.arguments.push(argument.into());
        self
    }

    /// The same with one more property.
    pub fn property(mut self, key: &str, value: impl Into<String>) -> Self {
        self.properties.push((key.to_owned(), value.into()));
        self
    }

    /// The message of a line without its end; `None` if the line is not of the protocol.
    /// Errors: The line begins like a message, but is none.
    pub fn parse(line: &str) -> Result<Option<Self>> {
        let Some(rest) = line.strip_prefix(PREFIX) else { return Ok(None) };
        let rest = rest.trim_end_matches(['\r', '\n']);
        let (name, mut rest) = rest.split_once(' ').unwrap_or((rest, ""));
        ensure!(
            !name.is_empty() && name.bytes().all(|byte| byte.is_ascii_alphanumeric()),
            "a message without a name: expected {PREFIX} and letters"
        );
        let mut message = Self::new(&name.to_ascii_lowercase());
        loop {
            rest = rest.trim_start_matches(' ');
            if rest.is_empty() {
                return Ok(Some(message));
            }
            let (field, after) = field(rest)?;
            rest = after;
            match field.split_once('=').filter(|(key, _)| is_key(key)) {
                Some((key, value)) => message.properties.push((key.to_owned(), value.to_owned())),
                // A path may hold an equals sign.
                None => message.arguments.push(field),
            }
        }
    }

    pub fn line(&self) -> String {
        let properties = self.properties.iter().map(|(key, value)| format!("{key}={value}"));
        let fields = self.arguments.iter().cloned().chain(properties);
        let fields: String = fields.map(|field| format!(" \"{}\"", escaped(&field))).collect();
        format!("{PREFIX}{}{fields}\n", self.name)
    }
}

/// The first field of what is not empty and does not begin with a space, and what follows it.
fn field(text: &str) -> Result<(String, &str)> {
    let quoted = text.starts_with('"');
    let inner = text.strip_prefix('"').unwrap_or(text);
    let mut field = String::new();
    let mut letters = inner.char_indices();
    while let Some((at, letter)) = letters.next() {
        match letter {
            '\\' => match letters.next() {
                Some((_, 'n')) => field.push('\n'),
                Some((_, other)) => field.push(other),
                None => bail!("the line ends with a backslash: expected a letter after it"),
            },
            '"' if quoted => {
                let rest = &inner[at + 1..];
                ensure!(rest.is_empty() || rest.starts_with(' '), "text follows a closing quote: expected a space");
                return Ok((field, rest));
            }
            ' ' if !quoted => return Ok((field, &inner[at..])),
            _ => field.push(letter),
        }
    }
    ensure!(!quoted, "a quote is open: expected a second one");
    Ok((field, ""))
}

fn is_key(text: &str) -> bool {
    let allowed = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'.' || byte == b'_';
    !text.is_empty() && text.len() <= MOST_KEY && text.bytes().all(allowed)
}

fn escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// As the client of vot-trax 4.0.2 writes them.
    #[test]
    fn messages_of_the_client() {
        let line = "@@TRAX:initialize \"file:///tmp/a b\\\"c.png\" \"1.0000,2.0000,3.0000,4.0000\" \"k=v v\" \n";
        let expected = Message::new("initialize")
            .argument("file:///tmp/a b\"c.png")
            .argument("1.0000,2.0000,3.0000,4.0000")
            .property("k", "v v");
        assert_eq!(Message::parse(line).unwrap(), Some(expected));
        let quit = Message::new("quit").property("trax.reason", "bye");
        assert_eq!(Message::parse("@@TRAX:QUIT trax.reason=bye\r\n").unwrap(), Some(quit));
        let equals = Message::new("frame").argument("file:///a=b.png").argument("image:1;1;gray8;AA==");
        assert_eq!(Message::parse("@@TRAX:frame file:///a=b.png \"image:1;1;gray8;AA==\"").unwrap(), Some(equals));
        assert_eq!(Message::parse("frame 1.png").unwrap(), None);
        assert_eq!(Message::parse("").unwrap(), None);
    }

    #[test]
    fn what_is_no_message_is_refused() {
        for (line, expected) in [
            ("@@TRAX:", "a message without a name"),
            ("@@TRAX: frame", "a message without a name"),
            ("@@TRAX:fr-ame", "a message without a name"),
            ("@@TRAX:frame \"a", "a quote is open"),
            ("@@TRAX:frame \"a\"b", "text follows a closing quote"),
            ("@@TRAX:frame a\\", "the line ends with a backslash"),
        ] {
            let error = Message::parse(line).unwrap_err().to_string();
            assert!(error.starts_with(expected), "{line}: {error}");
        }
    }

    proptest! {
        #[test]
        fn any_line_is_read_or_refused(line in "(@@TRAX:)?[a-z ]{0,8}[ -~\\n]{0,60}|\\PC{0,80}") {
            let _ = Message::parse(&line);
        }

        #[test]
        fn what_is_written_reads_back(
            arguments in proptest::collection::vec("[^=\\r]{0,20}", 0..4),
            properties in proptest::collection::vec(("[a-zA-Z0-9._]{1,64}", "[^\\r]{0,20}"), 0..4),
        ) {
            let message = Message { name: "frame".to_owned(), arguments, properties };
            prop_assert_eq!(Message::parse(message.line().trim_end_matches('\n')).unwrap(), Some(message));
        }
    }
}
