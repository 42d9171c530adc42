//! RON and JSON text to a [tree](super::tree).
//!
//! One grammar holds both: brackets with or without keys, names, numbers, texts and comments. RON is read as the `ron`
//! crate reads it, but for chars, bytes and attributes, which no scene needs; what `ron` writes of a scene is read back.
//! There is one pass and no backtracking, nesting is limited, and so is the length of a file: the memory that a file can
//! ask for is some twenty times its length.

use super::tree::{Field, Node, Place, Value};

/// Most bytes of a file.
pub(crate) const MOST_BYTES: usize = 4 << 20;
/// Deepest nesting of brackets.
const DEEPEST: usize = 48;
/// Most keys of one record: looking for double ones takes the square of it.
const MOST_KEYS: usize = 1000;

/// A mistake of syntax.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SyntaxError {
    pub at: Place,
    pub what: String,
}

type Parsed<T> = Result<T, SyntaxError>;

/// Reads a whole file; `file` is the index its places get.
pub(crate) fn parse(text: &str, file: usize) -> Parsed<Node> {
    let mut parser = Parser {
        rest: text.trim_start_matches('\u{feff}'),
        at: Place {
            file,
            line: 1,
            column: 1,
        },
        depth: 0,
    };
    if text.len() > MOST_BYTES {
        return Err(parser.wrong(format!(
            "the file has {} bytes, at most {MOST_BYTES} are read",
            text.len()
        )));
    }
    parser.space()?;
    let node = parser.value()?;
    parser.space()?;
    match parser.peek() {
        None => Ok(node),
        Some(c) => Err(parser.wrong(format!("{c:?} stands after the end of the scene"))),
    }
}

struct Parser<'a> {
    rest: &'a str,
    at: Place,
    depth: usize,
}

impl<'a> Parser<'a> {
    fn wrong(&self, what: impl Into<String>) -> SyntaxError {
        SyntaxError {
            at: self.at,
            what: what.into(),
        }
    }

    fn peek(&self) -> Option<char> {
        self.rest.chars().next()
    }

    fn next(&mut self) -> Option<char> {
        let c = self.peek()?;
        self.rest = &self.rest[c.len_utf8()..];
        if c == '\n' {
            self.at.line += 1;
            self.at.column = 1;
        } else {
            self.at.column += 1;
        }
        Some(c)
    }

    fn skip(&mut self, n: usize) {
        for _ in 0..n {
            self.next();
        }
    }

    fn eat(&mut self, c: char) -> bool {
        let there = self.peek() == Some(c);
        if there {
            self.next();
        }
        there
    }

    /// Blanks and comments.
    fn space(&mut self) -> Parsed<()> {
        loop {
            if self.rest.starts_with("//") {
                while self.peek().is_some_and(|c| c != '\n') {
                    self.next();
                }
            } else if self.rest.starts_with("/*") {
                let open = self.wrong("the comment has no end, `*/`");
                self.skip(2);
                let mut depth = 1;
                while depth > 0 {
                    if self.rest.starts_with("/*") {
                        self.skip(2);
                        depth += 1;
                    } else if self.rest.starts_with("*/") {
                        self.skip(2);
                        depth -= 1;
                    } else if self.next().is_none() {
                        return Err(open);
                    }
                }
            } else if self.peek().is_some_and(char::is_whitespace) {
                self.next();
            } else {
                return Ok(());
            }
        }
    }

    fn value(&mut self) -> Parsed<Node> {
        let at = self.at;
        let node = |value| Node { at, value };
        let Some(c) = self.peek() else {
            return Err(self.wrong("the file ends where a value must stand"));
        };
        match c {
            '(' => self.nested(')').map(node),
            '[' => self.nested(']').map(node),
            '{' => self.nested('}').map(node),
            '"' => Ok(node(Value::Text(self.text()?))),
            '0'..='9' | '-' | '+' | '.' => Ok(node(Value::Number(self.number()?))),
            _ if self.is_raw() => Ok(node(Value::Text(self.raw()?))),
            _ if c.is_alphabetic() || c == '_' => self.named(at),
            _ => Err(self.wrong(format!("{c:?} can't begin a value"))),
        }
    }

    /// A word, and what stands in the brackets behind it.
    fn named(&mut self, at: Place) -> Parsed<Node> {
        let name = self.word();
        let value = match name {
            "true" => Value::Flag(true),
            "false" => Value::Flag(false),
            "inf" => Value::Number(f64::INFINITY),
            "NaN" => Value::Number(f64::NAN),
            "None" | "null" => Value::Nothing,
            _ => {
                self.space()?;
                if self.peek() != Some('(') {
                    Value::Named(name.into(), None)
                } else {
                    let inside = self.at;
                    let value = self.nested(')')?;
                    let inner = Node { at: inside, value };
                    match (name, inner.value) {
                        ("Some", Value::List(mut items)) if items.len() == 1 => {
                            return Ok(items.swap_remove(0));
                        }
                        (_, value) => {
                            let inner = Node { at: inside, value };
                            Value::Named(name.into(), Some(Box::new(inner)))
                        }
                    }
                }
            }
        };
        Ok(Node { at, value })
    }

    fn word(&mut self) -> &'a str {
        let part = |c: char| c.is_alphanumeric() || c == '_';
        let end = self.rest.find(|c| !part(c)).unwrap_or(self.rest.len());
        let word = &self.rest[..end];
        self.skip(word.chars().count());
        word
    }

    /// What stands between brackets: fields if the first thing is a key, items otherwise.
    fn nested(&mut self, close: char) -> Parsed<Value> {
        if self.depth == DEEPEST {
            return Err(self.wrong(format!("brackets are nested more than {DEEPEST} deep")));
        }
        let unclosed = self.wrong(format!("this bracket has no end, `{close}`"));
        self.next();
        self.depth += 1;
        self.space()?;
        let keyed = close == '}' || (close == ')' && self.at_key());
        let (mut items, mut fields) = (Vec::new(), Vec::new());
        while !self.eat(close) {
            if self.peek().is_none() {
                return Err(unclosed);
            }
            if keyed {
                fields.push(self.field(&fields)?);
            } else {
                items.push(self.value()?);
            }
            self.space()?;
            if !self.eat(',') && self.peek() != Some(close) {
                return Err(match self.peek() {
                    None => unclosed,
                    Some(c) => self.wrong(format!("{c:?} stands where `,` or `{close}` must be")),
                });
            }
            self.space()?;
        }
        self.depth -= 1;
        Ok(if keyed {
            Value::Record(fields)
        } else {
            Value::List(items)
        })
    }

    /// Whether a word and a colon come next.
    fn at_key(&self) -> bool {
        let mut ahead = Parser {
            rest: self.rest,
            at: self.at,
            depth: 0,
        };
        let word = ahead.word();
        !word.is_empty() && ahead.space().is_ok() && ahead.peek() == Some(':')
    }

    fn field(&mut self, before: &[Field]) -> Parsed<Field> {
        let at = self.at;
        let key = match self.peek() {
            Some('"') => self.text()?,
            _ => self.word().to_owned(),
        };
        if key.is_empty() {
            let found = self.peek().map_or("the end".into(), |c| format!("{c:?}"));
            return Err(self.wrong(format!("{found} stands where a key must be")));
        }
        if before.len() == MOST_KEYS {
            return Err(self.wrong(format!("a record has at most {MOST_KEYS} keys")));
        }
        if before.iter().any(|f| f.key == key) {
            let what = format!("the key `{key}` stands twice");
            return Err(SyntaxError { at, what });
        }
        self.space()?;
        if !self.eat(':') {
            return Err(self.wrong(format!("`:` is missing after the key `{key}`")));
        }
        self.space()?;
        let value = self.value()?;
        Ok(Field { key, at, value })
    }

    fn number(&mut self) -> Parsed<f64> {
        let start = self.at;
        let part = |c: char| c.is_alphanumeric() || matches!(c, '.' | '+' | '-' | '_');
        let mut end = 0;
        for (i, c) in self.rest.char_indices() {
            // A sign belongs to the number at its beginning and after an exponent's mark.
            let sign = matches!(c, '+' | '-') && i > 0;
            if !part(c) || (sign && !self.rest[..i].ends_with(['e', 'E'])) {
                break;
            }
            end = i + c.len_utf8();
        }
        let written = &self.rest[..end];
        self.skip(written.chars().count());
        let digits = written.replace('_', "");
        let plain = digits.strip_prefix(['-', '+']).unwrap_or(&digits);
        let number = match plain {
            "inf" | "NaN" => digits.parse(),
            // Rust would read words that RON does not know.
            _ if plain.starts_with(|c: char| c.is_ascii_digit() || c == '.') => digits.parse(),
            _ => "".parse(),
        };
        number.map_err(|_| SyntaxError {
            at: start,
            what: format!("`{written}` is no number; a formula stands in quotes"),
        })
    }

    fn text(&mut self) -> Parsed<String> {
        let open = self.wrong("this text has no end, `\"`");
        self.next();
        let mut text = String::new();
        loop {
            match self.next() {
                None => return Err(open),
                Some('"') => return Ok(text),
                Some('\\') => text.push(self.escape()?),
                Some(c) => text.push(c),
            }
        }
    }

    fn escape(&mut self) -> Parsed<char> {
        let wrong = self.wrong("this escape is unknown; write `\\\\` for a backslash");
        Ok(match self.next() {
            Some('n') => '\n',
            Some('t') => '\t',
            Some('r') => '\r',
            Some('0') => '\0',
            Some(c @ ('"' | '\\' | '/' | '\'')) => c,
            Some('u') => {
                let braced = self.eat('{');
                let hex = |c: char| c.is_ascii_hexdigit();
                let most = if braced { 6 } else { 4 };
                let digits: String = self
                    .rest
                    .chars()
                    .take(most)
                    .take_while(|c| hex(*c))
                    .collect();
                self.skip(digits.len());
                let code = u32::from_str_radix(&digits, 16).ok();
                let c = code.and_then(char::from_u32);
                if braced && !self.eat('}') {
                    return Err(wrong);
                }
                return c.ok_or(wrong);
            }
            _ => return Err(wrong),
        })
    }

    fn is_raw(&self) -> bool {
        let hashes = self
            .rest
            .strip_prefix('r')
            .map(|r| r.trim_start_matches('#'));
        hashes.is_some_and(|r| r.starts_with('"'))
    }

    /// `r"…"` and `r#"…"#`.
    fn raw(&mut self) -> Parsed<String> {
        let open = self.wrong("this raw text has no end");
        let hashes = self.rest[1..].chars().take_while(|c| *c == '#').count();
        self.skip(hashes + 2);
        let close = format!("\"{}", "#".repeat(hashes));
        let end = self.rest.find(&close).ok_or(open)?;
        let text = self.rest[..end].to_owned();
        self.skip(text.chars().count() + hashes + 1);
        Ok(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Value {
        parse(text, 0).unwrap().value
    }

    fn mistake(text: &str) -> (u32, u32, String) {
        let e = parse(text, 0).unwrap_err();
        (e.at.line, e.at.column, e.what)
    }

    #[test]
    fn ron_and_json_give_the_same_tree() {
        let ron =
            "( // a scene\n a: 1.5e-3, b: [true, None, \"x\\n\"], /* c */ c: (1, -2, +3.5,),)";
        let json = r#"{"a": 1.5e-3, "b": [true, null, "x\n"], "c": [1, -2, 3.5]}"#;
        let strip = |text| format!("{:?}", read(text)).replace(|c: char| c.is_ascii_digit(), "");
        let [ron, json] = [ron, json].map(strip);
        assert_eq!(
            ron.split("at: Place").count(),
            json.split("at: Place").count()
        );
        assert_eq!(read("1_000"), Value::Number(1000.0));
        assert_eq!(read("-inf"), Value::Number(f64::NEG_INFINITY));
        assert_eq!(read(".5"), Value::Number(0.5));
        assert_eq!(read("r#\"a\"b\"#"), Value::Text("a\"b".into()));
        assert_eq!(read("\"\\u{e9}\\u00e9\""), Value::Text("éé".into()));
        assert_eq!(read("Some(3)"), Value::Number(3.0));
        assert_eq!(read("Fixed"), Value::Named("Fixed".into(), None));
        assert!(matches!(read("Ball(0.5)"), Value::Named(_, Some(_))));
    }

    #[test]
    fn places_are_those_of_the_values() {
        let tree = parse("(\n  a: 1,\n  b: (c: \"é\", d: 2),\n)", 7).unwrap();
        let d = tree.get("b").and_then(|b| b.get("d")).unwrap();
        let at = Place {
            file: 7,
            line: 3,
            column: 18,
        };
        assert_eq!(d.at, at);
    }

    #[test]
    fn mistakes_are_located() {
        for (text, line, column, what) in [
            ("(a: 1", 1, 1, "has no end"),
            ("(a: 1,\n a: 2)", 2, 2, "twice"),
            ("(a 1)", 1, 4, "where `,` or `)`"),
            ("{a 1}", 1, 4, "`:` is missing"),
            ("(a: 1/60)", 1, 6, "where `,` or `)`"),
            ("[1, 2", 1, 1, "has no end"),
            ("\"abc", 1, 1, "has no end"),
            ("(a: 1e)", 1, 5, "no number"),
            ("(a: 1) 2", 1, 8, "after the end"),
            ("", 1, 1, "ends"),
            ("/* x", 1, 1, "comment"),
            ("-infinity", 1, 1, "no number"),
            ("\"\\q\"", 1, 3, "escape"),
        ] {
            let (l, c, message) = mistake(text);
            assert_eq!((l, c), (line, column), "{text}: {message}");
            assert!(message.contains(what), "{text}: {message}");
        }
        let deep = "[".repeat(100_000);
        assert!(mistake(&deep).2.contains("nested"));
    }
}
