//! All scenes by name.

use super::{
    Scene, cantilever, cradle, drop, gripper, pile, pole, rubber_drop, slalom, terrain, thin_plate,
    trampoline, wall,
};

/// There is no scene of this name.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no scene `{name}`; {}", hint(*.suggestion))]
pub struct UnknownScene {
    /// What was asked for.
    pub name: String,
    /// The nearest name, if one is near.
    pub suggestion: Option<&'static str>,
}

fn hint(suggestion: Option<&'static str>) -> String {
    match suggestion {
        Some(name) => format!("did you mean `{name}`?"),
        None => {
            let names: Vec<&str> = all().iter().map(|s| s.name).collect();
            format!("there are: {}", names.join(", "))
        }
    }
}

/// Every scene.
pub fn all() -> &'static [Scene] {
    &[
        wall::SCENE,
        drop::SCENE,
        pole::SCENE,
        terrain::SCENE,
        slalom::SCENE,
        trampoline::SCENE,
        pile::SCENE,
        thin_plate::SCENE,
        cradle::SCENE,
        cantilever::SCENE,
        rubber_drop::SCENE,
        gripper::SCENE,
    ]
}

/// The scene of a name.
///
/// # Errors
/// [`UnknownScene`], with the nearest name where one differs by no more than half of what was asked for.
pub fn find(name: &str) -> Result<&'static Scene, UnknownScene> {
    all().iter().find(|s| s.name == name).ok_or_else(|| {
        let nearest = all()
            .iter()
            .map(|s| (distance(&name.to_lowercase(), s.name), s.name))
            .min();
        UnknownScene {
            name: name.to_owned(),
            suggestion: nearest
                .filter(|(d, _)| 2 * d <= name.chars().count())
                .map(|(_, n)| n),
        }
    })
}

/// How many letters must be put in, left out or changed to make one word of the other (Levenshtein).
pub(super) fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut corner = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let change = corner + usize::from(x != *y);
            corner = row[j + 1];
            row[j + 1] = change.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_found_or_suggested() {
        assert_eq!(find("wall").unwrap().name, "wall");
        for near in ["wal", "Wall", "walll", "wlal"] {
            assert_eq!(find(near).unwrap_err().suggestion, Some("wall"), "{near}");
        }
        let far = find("aeroplane").unwrap_err();
        assert_eq!(far.suggestion, None);
        assert!(far.to_string().contains("wall, drop"), "{far}");
    }

    #[test]
    fn scenes_have_different_names_and_one_line_of_text() {
        for (i, scene) in all().iter().enumerate() {
            assert!(all()[..i].iter().all(|s| s.name != scene.name));
            assert!(!scene.about.is_empty() && !scene.about.contains('\n'));
        }
    }
}
