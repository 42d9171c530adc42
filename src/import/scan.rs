//! Reading numbers from a file in memory, text or binary, with the place of the first wrong one.
//!
//! Both kinds of file go through one cursor, so a format that comes in both is parsed by one set of functions. Nothing is
//! allocated by a count the file states before that count is compared with the bytes that are left.

use super::ImportError;
use std::path::Path;

/// How numbers stand in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    /// Words separated by white space.
    Text,
    /// Packed, `int` of 4 bytes, sizes of `size` bytes, `double` of 8.
    Binary { big_endian: bool, size: usize },
}

/// A place in a file.
pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    line: usize,
    name: &'a Path,
    pub coding: Coding,
}

impl<'a> Cursor<'a> {
    pub fn new(bytes: &'a [u8], name: &'a Path) -> Self {
        Self {
            bytes,
            at: 0,
            line: 1,
            name,
            coding: Coding::Text,
        }
    }

    /// An error at the current place.
    pub fn wrong(&self, what: &'static str, value: impl Into<String>, must: &str) -> ImportError {
        let (value, must) = (value.into(), must.to_string());
        match self.coding {
            Coding::Text => ImportError::Line {
                path: self.name.into(),
                line: self.line,
                what,
                value,
                must,
            },
            Coding::Binary { .. } => ImportError::Byte {
                path: self.name.into(),
                byte: self.at,
                what,
                value,
                must,
            },
        }
    }

    /// Whether all is read.
    pub fn ended(&self) -> bool {
        self.at >= self.bytes.len()
    }

    fn advance(&mut self, to: usize) {
        let to = to.min(self.bytes.len());
        self.line += self.bytes[self.at..to]
            .iter()
            .filter(|&&b| b == b'\n')
            .count();
        self.at = to;
    }

    /// The rest of the line, its end left out, trimmed.
    pub fn line(&mut self) -> String {
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        let text = String::from_utf8_lossy(&rest[..length]).trim().to_string();
        self.advance(self.at + length + 1);
        text
    }

    /// The next line that is not empty and not a comment, a comment at its end cut off. `None` at the end of the file.
    pub fn row(&mut self) -> Option<(usize, String)> {
        while !self.ended() {
            let number = self.line;
            let line = self.line();
            let kept = line.split('#').next().unwrap_or_default().trim();
            if !kept.is_empty() {
                return Some((number, kept.to_string()));
            }
        }
        None
    }

    /// Goes behind the next `mark`.
    pub fn skip_past(&mut self, mark: &str) -> Result<(), ImportError> {
        let found = self.bytes[self.at..]
            .windows(mark.len())
            .position(|w| w == mark.as_bytes());
        match found {
            Some(i) => {
                self.advance(self.at + i + mark.len());
                Ok(())
            }
            None => Err(self.wrong("the end of the file", "", &format!("after {mark}"))),
        }
    }

    /// Refuses a count of things of at least `least` bytes each that can't be in what is left of the file.
    pub fn room_for(
        &self,
        what: &'static str,
        count: usize,
        least: usize,
    ) -> Result<(), ImportError> {
        let left = self.bytes.len() - self.at;
        if count.checked_mul(least).is_none_or(|need| need > left) {
            let must = format!("at most what the {left} bytes left can hold");
            return Err(self.wrong(what, count.to_string(), &must));
        }
        Ok(())
    }

    fn word(&mut self, what: &'static str) -> Result<&'a str, ImportError> {
        let space = |b: &u8| b.is_ascii_whitespace();
        let rest = &self.bytes[self.at..];
        let skip = rest.iter().position(|b| !space(b)).unwrap_or(rest.len());
        self.advance(self.at + skip);
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(space).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.wrong(what, "", "there; the file ends too early"));
        }
        let word = std::str::from_utf8(&rest[..length])
            .map_err(|_| self.wrong(what, String::from_utf8_lossy(&rest[..length]), "text"))?;
        self.at += length;
        Ok(word)
    }

    fn packed<const N: usize>(
        &mut self,
        what: &'static str,
        big: bool,
    ) -> Result<[u8; N], ImportError> {
        let Some(Ok(mut bytes)) = self
            .bytes
            .get(self.at..self.at + N)
            .map(<[u8; N]>::try_from)
        else {
            return Err(self.wrong(what, "", "there; the file ends too early"));
        };
        self.at += N;
        if big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    /// An `int`.
    pub fn int(&mut self, what: &'static str) -> Result<i64, ImportError> {
        match self.coding {
            Coding::Text => {
                let word = self.word(what)?;
                word.parse()
                    .map_err(|_| self.wrong(what, word, "a whole number"))
            }
            Coding::Binary { big_endian, .. } => {
                Ok(i32::from_le_bytes(self.packed(what, big_endian)?).into())
            }
        }
    }

    /// A size or a tag.
    pub fn size(&mut self, what: &'static str) -> Result<usize, ImportError> {
        let value = match self.coding {
            Coding::Text => {
                let word = self.word(what)?;
                return word
                    .parse()
                    .map_err(|_| self.wrong(what, word, "a whole number, zero or more"));
            }
            Coding::Binary {
                big_endian,
                size: 4,
            } => u64::from(u32::from_le_bytes(self.packed(what, big_endian)?)),
            Coding::Binary { big_endian, .. } => u64::from_le_bytes(self.packed(what, big_endian)?),
        };
        usize::try_from(value).map_err(|_| self.wrong(what, value.to_string(), "smaller"))
    }

    /// A finite `double`.
    pub fn double(&mut self, what: &'static str) -> Result<f64, ImportError> {
        let (value, text) = match self.coding {
            Coding::Text => {
                let word = self.word(what)?;
                (word.parse().unwrap_or(f64::NAN), word.to_string())
            }
            Coding::Binary { big_endian, .. } => {
                let value = f64::from_le_bytes(self.packed(what, big_endian)?);
                (value, value.to_string())
            }
        };
        if value.is_finite() {
            return Ok(value);
        }
        Err(self.wrong(what, text, "a finite number"))
    }
}
