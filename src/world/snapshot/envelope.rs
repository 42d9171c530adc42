//! What is around the bytes of a snapshot: who wrote it, how long it is, and whether it is whole.

use super::SnapshotError;
use crate::math::Fnv;
use crate::world::DeformableBuilder;
use crate::{body::Material, shape};
use rapier3d::prelude::*;
use std::cmp::Ordering;

/// What every snapshot begins with.
const MAGIC: &[u8] = b"crumple snapshot\n";
/// Goes up whenever anything that is saved changes within a version.
const FORMAT: u32 = 18;
const VERSION: &str = env!("CARGO_PKG_VERSION");

/// What a snapshot holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Deformables and Rapier's world.
    Whole,
    /// Deformables alone.
    Beside,
}

/// What tells how a small world is laid out from another way: Rapier says nothing of the version of what it saves.
fn layout() -> u64 {
    let mut world = PhysicsWorld::default();
    let bodies = [0.0, 1.0].map(|x| {
        let body = RigidBodyBuilder::dynamic().translation(Vector::X * x);
        world
            .insert(body, ColliderBuilder::cuboid(0.25, 0.5, 0.5))
            .0
    });
    world.insert_impulse_joint(bodies[0], bodies[1], FixedJointBuilder::new());
    let body = DeformableBuilder::new(shape::lattice(Vector::ONE, 1.0))
        .material(Material::rubber())
        .build();
    let mut bytes = FORMAT.to_le_bytes().to_vec();
    bytes.extend(postcard::to_stdvec(&world).unwrap_or_default());
    bytes.extend(postcard::to_stdvec(&body.ok()).unwrap_or_default());
    Fnv::of_bytes(&bytes)
}

/// Puts an envelope around what is saved.
pub(super) fn wrap(kind: Kind, content: &[u8]) -> Vec<u8> {
    let mut bytes = MAGIC.to_vec();
    bytes.push(VERSION.len() as u8);
    bytes.extend(VERSION.as_bytes());
    bytes.extend(layout().to_le_bytes());
    bytes.push(kind as u8);
    bytes.extend((content.len() as u64).to_le_bytes());
    bytes.extend(Fnv::of_bytes(content).to_le_bytes());
    bytes.extend(content);
    bytes
}

/// What is left to be read of an envelope.
struct Reader<'a> {
    left: &'a [u8],
    length: u64,
}

impl<'a> Reader<'a> {
    fn take(&mut self, n: usize) -> Result<&'a [u8], SnapshotError> {
        let cut = SnapshotError::CutShort {
            found: self.length,
            expected: None,
        };
        let (taken, left) = self.left.split_at_checked(n).ok_or(cut)?;
        self.left = left;
        Ok(taken)
    }

    fn number(&mut self) -> Result<u64, SnapshotError> {
        let mut number = [0; 8];
        number.copy_from_slice(self.take(8)?);
        Ok(u64::from_le_bytes(number))
    }
}

/// What is in an envelope that is whole, and of this version and layout.
pub(super) fn open(bytes: &[u8], kind: Kind) -> Result<&[u8], SnapshotError> {
    let begun = bytes.len().min(MAGIC.len());
    if bytes[..begun] != MAGIC[..begun] {
        return Err(SnapshotError::NoSnapshot {
            length: bytes.len(),
        });
    }
    let mut reader = Reader {
        left: bytes,
        length: bytes.len() as u64,
    };
    reader.take(MAGIC.len())?;
    let letters = reader.take(1)?[0];
    let found = String::from_utf8_lossy(reader.take(letters.into())?).into_owned();
    if found != VERSION {
        let expected = VERSION;
        return Err(SnapshotError::Version { found, expected });
    }
    let (found, expected) = (reader.number()?, layout());
    if found != expected {
        return Err(SnapshotError::Layout { found, expected });
    }
    if reader.take(1)?[0] != kind as u8 {
        return Err(match kind {
            Kind::Whole => SnapshotError::WithoutRapier,
            Kind::Beside => SnapshotError::WithRapier,
        });
    }
    let (size, sum) = (reader.number()?, reader.number()?);
    let content = reader.left;
    let expected = ((bytes.len() - content.len()) as u64).saturating_add(size);
    let found = bytes.len() as u64;
    match found.cmp(&expected) {
        Ordering::Less => {
            let expected = Some(expected);
            Err(SnapshotError::CutShort { found, expected })
        }
        Ordering::Greater => Err(SnapshotError::TooLong { found, expected }),
        Ordering::Equal if Fnv::of_bytes(content) != sum => Err(SnapshotError::Damaged),
        Ordering::Equal => Ok(content),
    }
}
