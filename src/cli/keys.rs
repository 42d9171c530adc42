//! `keys`: the reference of scene files, from the declarations themselves.

use super::Failure;
use crumple::scenario::file::{Entry, reference};

pub fn print(of: Option<&str>) -> Result<(), Failure> {
    let entries = reference();
    let within =
        |e: &Entry, name: &str| e.owner == name || e.owner.starts_with(&format!("{name}::"));
    let chosen: Vec<&Entry> = match of {
        None => entries.iter().collect(),
        Some(name) => entries.iter().filter(|e| within(e, name)).collect(),
    };
    if chosen.is_empty() {
        let mut owners: Vec<&str> = entries.iter().map(|e| e.owner).collect();
        owners.retain(|o| !o.contains("::"));
        owners.dedup();
        let what = of.unwrap_or_default();
        let all = owners.join(", ");
        return Err(Failure::Wrong(format!(
            "there is no `{what}`; there are: {all}"
        )));
    }
    for entry in chosen {
        say_line!("{}", line(entry));
    }
    Ok(())
}

fn line(e: &Entry) -> String {
    let doc = e.doc.split_whitespace().collect::<Vec<_>>().join(" ");
    let doc = doc.replace('\\', "");
    let value = match (e.kind, e.default) {
        ("", _) => String::new(),
        (kind, "") => format!(": {kind}"),
        (kind, default) => format!(": {kind} = {default}"),
    };
    match e.key {
        "" => format!("\n{} – {doc}", e.owner),
        key if e.owner.contains("::") => format!("      {key}{value} – {doc}"),
        key => format!("  {key}{value} – {doc}"),
    }
}
