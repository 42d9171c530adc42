//! Formulas: what a text means where a number may stand.
//!
//! A variable must be written so that RON and JSON both take it, an editor colours it, and nobody mistakes it for the name
//! of a thing. A text in the place of a number is all that: no such place takes texts, so `"speed"` can only be the
//! variable, and since a text can hold more than a name, `"speed / 3.6"` and `"sqrt(2 * 9.81 * height)"` come with it. A
//! mark such as `$speed` would be no RON at all without the quotes, and noise within them.
//!
//! The same formulas, with `x`, `y`, `z` for a place or `t` for the time, say which nodes are meant and how a force
//! changes. `+ - * / ^`, comparisons (1 for true, 0 for false), `&& || !`, brackets, the functions of [`FUNCTIONS`],
//! `random(i)` (from 0 to 1, by the scene's seed), and the constants of [`CONSTANTS`].

use std::collections::BTreeMap;
use std::f64::consts::PI;

/// Values of variables by name.
pub type Variables = BTreeMap<String, f64>;

/// Deepest nesting of brackets and signs.
const DEEPEST: usize = 48;
/// Longest formula \[bytes\].
const LONGEST: usize = 1000;

/// Constants by name: π, a degree in radians, standard gravity \[m/s²\], infinity.
pub const CONSTANTS: [(&str, f64); 4] = [
    ("pi", PI),
    ("deg", PI / 180.0),
    ("g", 9.806_65),
    ("inf", f64::INFINITY),
];

/// Functions by name and number of arguments.
pub const FUNCTIONS: [(&str, usize, Function); 18] = [
    ("sqrt", 1, |a| a[0].sqrt()),
    ("abs", 1, |a| a[0].abs()),
    ("exp", 1, |a| a[0].exp()),
    ("ln", 1, |a| a[0].ln()),
    ("sin", 1, |a| a[0].sin()),
    ("cos", 1, |a| a[0].cos()),
    ("tan", 1, |a| a[0].tan()),
    ("asin", 1, |a| a[0].asin()),
    ("acos", 1, |a| a[0].acos()),
    ("sinh", 1, |a| a[0].sinh()),
    ("cosh", 1, |a| a[0].cosh()),
    ("tanh", 1, |a| a[0].tanh()),
    ("round", 1, |a| a[0].round()),
    ("floor", 1, |a| a[0].floor()),
    ("atan2", 2, |a| a[0].atan2(a[1])),
    ("hypot", 2, |a| a[0].hypot(a[1])),
    ("min", 2, |a| a[0].min(a[1])),
    ("max", 2, |a| a[0].max(a[1])),
];

/// A number from 0 to 1 that `random(i)` gives for a seed: SplitMix64 of both.
fn random(i: f64, seed: f64) -> f64 {
    let mut z = i.to_bits() ^ seed.to_bits().rotate_left(32);
    for _ in 0..2 {
        z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
    }
    (z >> 11) as f64 / (1_u64 << 53) as f64
}

/// A function of one or two numbers.
pub type Function = fn(&[f64; 2]) -> f64;

/// A formula, ready to be evaluated.
#[derive(Clone, Debug)]
pub struct Formula {
    text: String,
    root: Term,
}

impl PartialEq for Formula {
    fn eq(&self, other: &Self) -> bool {
        self.text == other.text
    }
}

#[derive(Clone, Debug)]
enum Term {
    Number(f64),
    /// A number that is given at each evaluation.
    Slot(usize),
    Call(Function, Box<[Term; 2]>),
}

impl Formula {
    /// Reads a formula. Names are those of `variables`, whose values are taken now, and of `slots`, whose values are given
    /// at each evaluation in this order.
    ///
    /// # Errors
    /// What is wrong, in words.
    pub fn new(text: &str, variables: &Variables, slots: &[&str]) -> Result<Self, String> {
        if text.len() > LONGEST {
            return Err(format!("the formula is longer than {LONGEST} bytes"));
        }
        let mut reader = Reader {
            rest: text,
            variables,
            slots,
            depth: 0,
        };
        let root = reader.binary(0)?;
        reader.space();
        match reader.rest {
            "" => Ok(Self {
                text: text.into(),
                root,
            }),
            rest => Err(format!("`{rest}` stands behind the end of the formula")),
        }
    }

    /// What was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Its value for these values of its slots; NaN for one that is not given.
    pub fn value(&self, slots: &[f64]) -> f64 {
        self.root.value(slots)
    }
}

impl Term {
    fn value(&self, slots: &[f64]) -> f64 {
        match self {
            Self::Number(x) => *x,
            Self::Slot(i) => slots.get(*i).copied().unwrap_or(f64::NAN),
            Self::Call(f, terms) => f(&[terms[0].value(slots), terms[1].value(slots)]),
        }
    }
}

fn truth(yes: bool) -> f64 {
    f64::from(u8::from(yes))
}

/// Binary operators by rising precedence; those of a line bind alike.
const LEVELS: [&[(&str, Function)]; 5] = [
    &[("||", |a| truth(a[0] != 0.0 || a[1] != 0.0))],
    &[("&&", |a| truth(a[0] != 0.0 && a[1] != 0.0))],
    &[
        ("<=", |a| truth(a[0] <= a[1])),
        (">=", |a| truth(a[0] >= a[1])),
        ("==", |a| truth(a[0] == a[1])),
        ("!=", |a| truth(a[0] != a[1])),
        ("<", |a| truth(a[0] < a[1])),
        (">", |a| truth(a[0] > a[1])),
    ],
    &[("+", |a| a[0] + a[1]), ("-", |a| a[0] - a[1])],
    &[("*", |a| a[0] * a[1]), ("/", |a| a[0] / a[1])],
];

struct Reader<'a> {
    rest: &'a str,
    variables: &'a Variables,
    slots: &'a [&'a str],
    depth: usize,
}

impl Reader<'_> {
    fn space(&mut self) {
        self.rest = self.rest.trim_start();
    }

    fn eat(&mut self, what: &str) -> bool {
        self.space();
        let rest = self.rest.strip_prefix(what);
        self.rest = rest.unwrap_or(self.rest);
        rest.is_some()
    }

    fn binary(&mut self, level: usize) -> Result<Term, String> {
        let Some(operators) = LEVELS.get(level) else {
            return self.unary();
        };
        let mut left = self.binary(level + 1)?;
        while let Some((_, f)) = operators.iter().find(|(sign, _)| self.eat(sign)) {
            let right = self.binary(level + 1)?;
            left = Term::Call(*f, Box::new([left, right]));
        }
        Ok(left)
    }

    fn unary(&mut self) -> Result<Term, String> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(format!("the formula is nested more than {DEEPEST} deep"));
        }
        let term = if self.eat("-") {
            call(|a| -a[0], self.unary()?)
        } else if self.eat("!") {
            call(|a| truth(a[0] == 0.0), self.unary()?)
        } else {
            let base = self.primary()?;
            match self.eat("^") {
                true => Term::Call(|a| a[0].powf(a[1]), Box::new([base, self.unary()?])),
                false => base,
            }
        };
        self.depth -= 1;
        Ok(term)
    }

    fn primary(&mut self) -> Result<Term, String> {
        if self.eat("(") {
            let inner = self.binary(0)?;
            return self.close().map(|()| inner);
        }
        let Some(first) = self.rest.chars().next() else {
            return Err("the formula ends where a number must stand".into());
        };
        if first.is_ascii_digit() || first == '.' {
            return self.number();
        }
        let part = |c: char| c.is_alphanumeric() || c == '_';
        let end = self.rest.find(|c| !part(c)).unwrap_or(self.rest.len());
        let (name, rest) = self.rest.split_at(end);
        if name.is_empty() {
            return Err(format!("{first:?} stands where a number must stand"));
        }
        self.rest = rest;
        if self.eat("(") {
            return self.call(name);
        }
        if let Some(i) = self.slots.iter().position(|slot| *slot == name) {
            return Ok(Term::Slot(i));
        }
        let constant = || CONSTANTS.iter().find(|(n, _)| *n == name).map(|(_, x)| *x);
        let value = self.variables.get(name).copied().or_else(constant);
        value.map(Term::Number).ok_or_else(|| {
            let names = self.variables.keys().map(String::as_str);
            let all = names.chain(self.slots.iter().copied());
            super::problem::unknown("variable", name, all)
        })
    }

    fn call(&mut self, name: &str) -> Result<Term, String> {
        if name == "random" {
            let seed = self.variables.get("seed").copied().unwrap_or(0.0);
            let i = self.binary(0)?;
            self.close()?;
            let terms = Box::new([i, Term::Number(seed)]);
            return Ok(Term::Call(|a| random(a[0], a[1]), terms));
        }
        let Some((_, count, f)) = FUNCTIONS.iter().find(|(n, ..)| *n == name) else {
            let names = FUNCTIONS.iter().map(|(n, ..)| *n);
            return Err(super::problem::unknown("function", name, names));
        };
        let first = self.binary(0)?;
        let second = match count {
            2 if !self.eat(",") => return Err(format!("`{name}` takes two numbers")),
            2 => self.binary(0)?,
            _ => Term::Number(0.0),
        };
        self.close()?;
        Ok(Term::Call(*f, Box::new([first, second])))
    }

    fn close(&mut self) -> Result<(), String> {
        match self.eat(")") {
            true => Ok(()),
            false => Err("a `)` is missing in the formula".into()),
        }
    }

    fn number(&mut self) -> Result<Term, String> {
        let mut end = 0;
        for (i, c) in self.rest.char_indices() {
            let sign = matches!(c, '+' | '-') && self.rest[..i].ends_with(['e', 'E']);
            if !(c.is_ascii_alphanumeric() || c == '.' || c == '_' || sign) {
                break;
            }
            end = i + c.len_utf8();
        }
        let (written, rest) = self.rest.split_at(end);
        self.rest = rest;
        let number = written.replace('_', "").parse().map(Term::Number);
        number.map_err(|_| format!("`{written}` is no number"))
    }
}

fn call(f: Function, term: Term) -> Term {
    Term::Call(f, Box::new([term, Term::Number(0.0)]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str) -> Result<f64, String> {
        let variables = Variables::from([("speed".into(), 36.0), ("h".into(), 2.0)]);
        Formula::new(text, &variables, &["x", "y"]).map(|f| f.value(&[3.0, 4.0]))
    }

    #[test]
    fn formulas_are_evaluated() {
        for (text, expected) in [
            ("speed", 36.0),
            ("speed / 3.6", 10.0),
            ("1 + 2 * 3 - -4", 11.0),
            ("2 ^ 3 ^ 2", 512.0),
            ("-2 ^ 2", -4.0),
            ("(1 + 2) * 3", 9.0),
            ("hypot(x, y)", 5.0),
            ("x > 2 && y <= 4 || 0", 1.0),
            ("!(x == 3)", 0.0),
            ("1e-3 * 1_000", 1.0),
            ("180 * deg - pi", 0.0),
            ("min(h, 1) + max(h, 1)", 3.0),
        ] {
            assert_eq!(value(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn random_numbers_are_spread_and_repeat() {
        let of = |seed: f64| -> Vec<f64> {
            let variables = Variables::from([("seed".into(), seed)]);
            let f = Formula::new("random(x)", &variables, &["x"]).unwrap();
            (0..1000).map(|i| f.value(&[f64::from(i)])).collect()
        };
        assert_eq!(of(1.0), of(1.0));
        assert_ne!(of(1.0), of(2.0));
        let mean = of(0.0).iter().sum::<f64>() / 1000.0;
        assert!((mean - 0.5).abs() < 0.05, "{mean}");
        assert!(of(3.0).iter().all(|x| (0.0..1.0).contains(x)));
    }

    #[test]
    fn mistakes_are_named() {
        for (text, what) in [
            ("sped", "did you mean `speed`?"),
            ("sqr(2)", "did you mean `sqrt`?"),
            ("1 +", "ends"),
            ("1 2", "behind the end"),
            ("(1", "`)`"),
            ("hypot(1)", "two"),
            ("", "ends"),
            ("1 + %", "'%'"),
            ("1.2.3", "no number"),
        ] {
            let error = value(text).unwrap_err();
            assert!(error.contains(what), "{text}: {error}");
        }
        assert!(value(&"(".repeat(900)).unwrap_err().contains("nested"));
        assert!(value(&"-".repeat(900)).unwrap_err().contains("nested"));
        assert!(value(&"1+".repeat(900)).unwrap_err().contains("longer"));
    }
}
