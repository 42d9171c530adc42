//! The variables of a scene: their values, whatever the order they stand in, and whether anything names them.

use super::decode::Decoder;
use super::formula::{CONSTANTS, Formula, Variables};
use super::load::LoadOptions;
use super::model::deformable::PLACE;
use super::problem::{Problem, unknown};
use super::tree::{Field, Node, Value};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// Keys whose texts are for people.
const SAID: [&str; 2] = ["about", "name"];

/// Values of the variables, with those that are set from outside, and what is wrong with them.
pub(super) fn variables(
    tree: &Node,
    files: &[PathBuf],
    options: &LoadOptions,
) -> (Variables, Vec<Problem>) {
    let (mut variables, mut problems) = (Variables::new(), Vec::new());
    let seed = tree.get("world").and_then(|w| w.get("seed"));
    let seed = match seed.map(|n| (n.at, &n.value)) {
        Some((_, Value::Number(x))) => *x,
        Some((at, _)) if options.seed.is_none() => {
            problems.push(Problem {
                file: files.get(at.file).cloned().unwrap_or_default(),
                line: at.line,
                column: at.column,
                key: "world.seed".into(),
                what: "must be a number: formulas draw from it, so it can't be one".into(),
            });
            0.0
        }
        _ => 0.0,
    };
    variables.insert("seed".into(), options.seed.map_or(seed, |s| s as f64));
    let fields = tree.get("variables").and_then(Node::fields).unwrap_or(&[]);
    let (order, circles) = by_need(fields, options);
    let mut wrong = |field: &Field, what: String| {
        problems.push(Problem {
            file: files.get(field.at.file).cloned().unwrap_or_default(),
            line: field.at.line,
            column: field.at.column,
            key: format!("variables.{}", field.key),
            what,
        });
    };
    for i in circles {
        wrong(
            &fields[i],
            "its value depends on itself, or on one that does".into(),
        );
    }
    for field in order.into_iter().map(|i| &fields[i]) {
        if let Err(what) = good_variable(&field.key) {
            wrong(field, what);
            continue;
        }
        let value = match (set(options, &field.key), &field.value.value) {
            (Some(x), _) => Ok(x),
            (None, Value::Number(x)) => Ok(*x),
            (None, Value::Text(text)) => Formula::new(text, &variables, &[]).map(|f| f.value(&[])),
            _ => Err("expected a number or a formula in quotes".into()),
        };
        match value {
            Ok(x) if x.is_finite() => _ = variables.insert(field.key.clone(), x),
            Ok(x) => wrong(field, format!("is {x}, it must be finite")),
            Err(what) => wrong(field, what),
        }
    }
    for (name, _) in &options.set {
        if !fields.iter().any(|f| f.key == *name) {
            let known = fields.iter().map(|f| f.key.as_str());
            problems.push(Problem {
                file: files.first().cloned().unwrap_or_default(),
                line: 0,
                column: 0,
                key: format!("--set {name}"),
                what: unknown("variable", name, known),
            });
        }
    }
    (variables, problems)
}

/// What a variable is set to from outside.
fn set(options: &LoadOptions, name: &str) -> Option<f64> {
    let mut set = options.set.iter().rev();
    set.find(|(n, _)| n == name).map(|(_, x)| *x)
}

/// The variables in an order in which each stands behind those its formula names, and those that have none.
fn by_need(fields: &[Field], options: &LoadOptions) -> (Vec<usize>, Vec<usize>) {
    let known: BTreeMap<&str, usize> = (0..)
        .zip(fields)
        .map(|(i, f)| (f.key.as_str(), i))
        .collect();
    let needs = |field: &Field| -> Vec<usize> {
        let formula = field
            .value
            .text()
            .filter(|_| set(options, &field.key).is_none());
        let words = formula.into_iter().flat_map(words);
        words.filter_map(|w| known.get(w).copied()).collect()
    };
    let needs: Vec<Vec<usize>> = fields.iter().map(needs).collect();
    let mut needed_by = vec![Vec::new(); fields.len()];
    let mut open: Vec<usize> = needs.iter().map(Vec::len).collect();
    for (i, needs) in needs.iter().enumerate() {
        needs.iter().for_each(|n| needed_by[*n].push(i));
    }
    let mut order: Vec<usize> = (0..fields.len()).filter(|i| open[*i] == 0).collect();
    let mut next = 0;
    while let Some(done) = order.get(next).copied() {
        next += 1;
        for &i in &needed_by[done] {
            open[i] -= 1;
            if open[i] == 0 {
                order.push(i);
            }
        }
    }
    let circles = (0..fields.len()).filter(|i| open[*i] > 0).collect();
    (order, circles)
}

/// The words of a formula but for the names of functions.
fn words(text: &str) -> impl Iterator<Item = &str> {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    let mut rest = text;
    std::iter::from_fn(move || {
        loop {
            rest = rest.trim_start_matches(|c| !part(c));
            let end = rest.find(|c| !part(c)).unwrap_or(rest.len());
            let (word, behind) = rest.split_at(end);
            rest = behind;
            if word.is_empty() {
                return None;
            }
            if !behind.trim_start().starts_with('(') {
                return Some(word);
            }
        }
    })
}

/// A variable that is set and that nothing names changes nothing: whoever sweeps over it would not notice. One that is not
/// set does no harm, and what a program writes of a scene, its numbers filled in, is full of them.
pub(super) fn unused(tree: &Node, options: &LoadOptions, d: &mut Decoder) {
    let mut named = BTreeSet::new();
    collect_words(tree, &mut named);
    for field in tree.get("variables").and_then(Node::fields).unwrap_or(&[]) {
        if set(options, &field.key).is_some() && !named.contains(field.key.as_str()) {
            let key = format!(".variables.{}", field.key);
            let what = "it is set, but nothing names this variable";
            d.within(key, |d| d.wrong(field.at, |_| what.into()));
        }
    }
}

fn collect_words<'a>(node: &'a Node, named: &mut BTreeSet<&'a str>) {
    match &node.value {
        Value::Text(text) => named.extend(words(text)),
        Value::List(items) => items.iter().for_each(|item| collect_words(item, named)),
        Value::Named(_, Some(inner)) => collect_words(inner, named),
        Value::Record(fields) => {
            let formulas = fields.iter().filter(|f| !SAID.contains(&f.key.as_str()));
            formulas.for_each(|f| collect_words(&f.value, named));
        }
        _ => {}
    }
}

fn good_variable(name: &str) -> Result<(), String> {
    let letters = |c: char| c.is_alphanumeric() || c == '_';
    let first = name.chars().next();
    if !first.is_some_and(|c| c.is_alphabetic() || c == '_') || !name.chars().all(letters) {
        return Err("the name of a variable is a word of letters, digits and `_`".into());
    }
    let taken = CONSTANTS.iter().any(|(n, _)| *n == name) || PLACE.contains(&name);
    if taken || name == "t" || name == "seed" {
        return Err("this name has a meaning in formulas already; choose another".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::words;

    #[test]
    fn words_are_those_that_can_be_variables() {
        let found: Vec<&str> = words("floor(speed / 2) + min (a_1, é)*2e3").collect();
        assert_eq!(found, ["speed", "2", "a_1", "é", "2e3"]);
    }
}
