//! Every shape that Rapier has, and meshes.

use super::super::check::{FINITE, Length, POINT, SIZE, WIDTH};
use super::super::decode::{Decode, Decoder, variant};
use super::super::formula::Formula;
use super::super::schema::{Entry, choice};
use super::super::tree::{Node, Value};
use crate::math::{Real, Vector};
use std::path::{Path, PathBuf};

/// Most bytes of all files of meshes together.
const MOST_DATA: u64 = 256 << 20;
/// Sides of the box around the hatchback \[m\].
const HATCHBACK: [f64; 3] = [4.2084, 1.479, 1.7504];
/// Most points of a hull, and of a surface that is cut into convex parts.
const MOST_OF_A_HULL: usize = 10_000;
const MOST_TO_CUT: f64 = 100_000.0;
/// Most points of one shape.
const POINTS: Length = Length {
    from: 1,
    to: 1_000_000,
};

choice! {
    /// The shape of a collider, about its own origin; the axis of round ones is y.
    pub enum Shape {
        /// A ball of this radius \[m\].
        Ball(f64, SIZE);
        /// A box.
        Cuboid {
            /// Half its sides \[m\].
            half: [f64; 3], SIZE;
            /// Radius of its edges, beyond the sides \[m\].
            border: f64 = 0.0, WIDTH;
        };
        /// A cylinder with round ends.
        Capsule {
            /// Half the length of the cylinder \[m\].
            half_height: f64, SIZE;
            /// Radius \[m\].
            radius: f64, SIZE;
            /// Along which axis it lies.
            axis: super::probe::Axis = super::probe::Axis::Y;
        };
        /// A cylinder.
        Cylinder {
            /// Half its height \[m\].
            half_height: f64, SIZE;
            /// Radius \[m\].
            radius: f64, SIZE;
            /// Radius of its edges, beyond \[m\].
            border: f64 = 0.0, WIDTH;
        };
        /// A cone with its tip up.
        Cone {
            /// Half its height \[m\].
            half_height: f64, SIZE;
            /// Radius of its base \[m\].
            radius: f64, SIZE;
            /// Radius of its edges, beyond \[m\].
            border: f64 = 0.0, WIDTH;
        };
        /// Everything on one side of a plane through the origin.
        HalfSpace {
            /// Where its outside is, any length.
            normal: [f64; 3], FINITE;
        };
        /// A line between two points.
        Segment {
            /// One end \[m\].
            a: [f64; 3], POINT;
            /// The other \[m\].
            b: [f64; 3], POINT;
        };
        /// A triangle.
        Triangle {
            /// First corner \[m\].
            a: [f64; 3], POINT;
            /// Second corner \[m\].
            b: [f64; 3], POINT;
            /// Third corner \[m\].
            c: [f64; 3], POINT;
            /// Radius of its edges \[m\].
            border: f64 = 0.0, WIDTH;
        };
        /// Lines from point to point.
        Polyline {
            /// The points \[m\].
            points: Vec<[f64; 3]>, POINT;
        };
        /// A surface of triangles.
        TriMesh(Mesh);
        /// Heights over a rectangle.
        HeightField {
            /// Rows along z of heights along x, as many in each \[m\].
            heights: Vec<Vec<f64>>, POINT;
            /// Whole length along x, factor on heights, whole length along z.
            size: [f64; 3], SIZE;
        };
        /// Ground over a rectangle about the origin whose height is a formula.
        Terrain {
            /// Height \[m\]: a formula of x and z.
            height: Relief;
            /// Its sides along x and z \[m\].
            size: [f64; 2], SIZE;
            /// Side of a cell \[m\].
            cell: f64, SIZE;
            /// Whether it is a mesh of the triangles that the height field has.
            mesh: bool = false;
        };
        /// The convex hull of points.
        Hull {
            /// The points \[m\].
            points: Vec<[f64; 3]>, POINT;
            /// Radius of its edges \[m\].
            border: f64 = 0.0, WIDTH;
        };
        /// Convex parts of a closed surface.
        Decomposition(Mesh);
        /// Little boxes on a grid.
        Voxels {
            /// Sides of one \[m\].
            size: [f64; 3], SIZE;
            /// Which are there: any point of each \[m\].
            points: Vec<[f64; 3]>, POINT;
        };
        /// Several shapes as one.
        Compound(Vec<Placed>, Length { from: 1, to: 1000 });
    }
}

/// The height of a ground: a formula of x and z.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief(pub Formula);

impl Decode for Relief {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        d.formula_of(node, &["x", "z"]).map(Self)
    }
}

impl serde::Serialize for Relief {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.text())
    }
}

super::super::schema::record! {
    /// A part of a compound.
    pub struct Placed {
        /// Its shape; not a compound itself.
        shape: Shape;
        /// Where it is \[m\].
        translation: [f64; 3] = [0.0; 3], POINT;
        /// How it is turned: an axis, as long as the angle \[rad\].
        rotation: [f64; 3] = [0.0; 3], FINITE;
    }
}

/// A surface: the car that comes with the crate, a file, a ball, or its own points and triangles.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub enum Mesh {
    /// The hatchback of the crash scenes: x forward, y up, tyres down to y = 0.
    Hatchback,
    /// A Wavefront OBJ file, relative to the scene's own.
    File(PathBuf),
    /// A ball of rings of quads.
    Ball {
        /// Its radius \[m\].
        radius: f64,
        /// Quads in a ring; a multiple of 4.
        around: usize,
        /// Rings; even.
        rings: usize,
    },
    /// Points and triangles.
    Points {
        /// Vertices \[m\].
        vertices: Vec<[f64; 3]>,
        /// Three indices of vertices each, counter-clockwise seen from outside.
        triangles: Vec<[u32; 3]>,
    },
}

/// The explicit form of a mesh.
mod explicit {
    use super::*;

    super::super::super::schema::record! {
        /// A surface by its points.
        pub struct Points {
            /// Vertices \[m\].
            vertices: Vec<[f64; 3]>, POINT;
            /// Three indices of vertices each, counter-clockwise seen from outside.
            triangles: Vec<[u32; 3]>, POINTS;
        }
        then indices
    }

    super::super::super::schema::record! {
        /// A ball of rings of quads, its quarters by turns in a colour of their own.
        pub struct Ball {
            /// Its radius \[m\].
            radius: f64, SIZE;
            /// Quads in a ring; a multiple of 4.
            around: usize = 24;
            /// Rings; even.
            rings: usize = 12;
        }
        then quarters
    }

    fn quarters(ball: &Ball, node: &Node, d: &mut Decoder) -> Option<()> {
        let fits = |n: usize, of: usize| n.is_multiple_of(of) && (of..=512).contains(&n);
        if fits(ball.around, 4) && fits(ball.rings, 2) {
            return Some(());
        }
        d.wrong(node.at, |_| {
            "`around` must be a multiple of 4 and `rings` even, both at most 512".into()
        });
        None
    }

    fn indices(points: &Points, node: &Node, d: &mut Decoder) -> Option<()> {
        let count = points.vertices.len();
        let mut all = points.triangles.iter().flatten();
        let Some(wrong) = all.find(|i| **i as usize >= count) else {
            return Some(());
        };
        d.wrong(node.at, |_| {
            format!("a triangle names vertex {wrong}, but there are {count}, counted from 0")
        });
        None
    }
}

impl Decode for Mesh {
    fn decode(node: &Node, d: &mut Decoder) -> Option<Self> {
        match variant(node) {
            Some(("Hatchback", None)) => return Some(Self::Hatchback),
            Some(("File" | "Points", Some(inner))) => return Self::decode(inner, d),
            Some(("Ball", Some(inner))) => {
                let ball = explicit::Ball::decode(inner, d)?;
                return Some(Self::Ball {
                    radius: ball.radius,
                    around: ball.around,
                    rings: ball.rings,
                });
            }
            _ => {}
        }
        match &node.value {
            Value::Text(_) => file(node, d, &["obj"]).map(Self::File),
            Value::Record(_) => {
                let points = explicit::Points::decode(node, d)?;
                Some(Self::Points {
                    vertices: points.vertices,
                    triangles: points.triangles,
                })
            }
            _ => d.expected(
                node,
                "Hatchback, the path of an OBJ file in quotes, Ball(radius: …), or (vertices: […], triangles: […])",
            ),
        }
    }
}

/// A path with one of these endings, made absolute.
pub(super) fn file(node: &Node, d: &mut Decoder, endings: &[&str]) -> Option<PathBuf> {
    let text = String::decode(node, d)?;
    let ending = std::path::Path::new(&text).extension();
    if !ending.is_some_and(|e| endings.iter().any(|known| e.eq_ignore_ascii_case(known))) {
        d.wrong(node.at, |_| {
            format!("{text:?} must end in .{}", endings.join(" or ."))
        });
        return None;
    }
    let from = d.files.get(node.at.file).cloned().unwrap_or_default();
    named(node, d, &from, &text)
}

/// The file of data that `text` means in the file `from`; complains of too many bytes in all.
pub(super) fn named(node: &Node, d: &mut Decoder, from: &Path, text: &str) -> Option<PathBuf> {
    let found = (d.locate)(from, text).and_then(|(path, bytes)| {
        d.data_bytes += bytes;
        match d.data_bytes {
            all if all > MOST_DATA => Err(format!(
                "with {text:?} the files of meshes have {all} bytes in all, at most {MOST_DATA} are read"
            )),
            _ => Ok(path),
        }
    });
    found.map_err(|what| d.wrong(node.at, |_| what)).ok()
}

impl Mesh {
    /// Sides of the box around it \[m\]; `None` for a file.
    pub(crate) fn sides(&self) -> Option<[f64; 3]> {
        match self {
            Self::Hatchback => Some(HATCHBACK),
            Self::File(_) => None,
            Self::Ball { radius, .. } => Some([2.0 * radius; 3]),
            Self::Points { vertices, .. } => Some(std::array::from_fn(|i| {
                let along = vertices.iter().map(|v| v[i]);
                let start = (f64::INFINITY, f64::NEG_INFINITY);
                let (low, high) = along.fold(start, |(lo, hi), x| (lo.min(x), hi.max(x)));
                high - low
            })),
        }
    }

    /// How many points it has; none for a file, whose bytes are limited.
    pub(crate) fn points(&self) -> f64 {
        match self {
            Self::Hatchback => 3000.0,
            Self::File(_) => 0.0,
            Self::Ball { around, rings, .. } => (around * rings) as f64,
            Self::Points {
                vertices,
                triangles,
            } => vertices.len().max(triangles.len()) as f64,
        }
    }
}

impl Shape {
    /// How many points it has, as far as that is known before files are read.
    pub(crate) fn points(&self) -> f64 {
        match self {
            Self::Polyline { points } | Self::Hull { points, .. } | Self::Voxels { points, .. } => {
                points.len() as f64
            }
            Self::HeightField { heights, .. } => heights.iter().map(|row| row.len() as f64).sum(),
            Self::Terrain { size, cell, .. } => {
                let along = size.map(|side| (side / cell).round().max(1.0) + 1.0);
                along.iter().product()
            }
            Self::TriMesh(mesh) | Self::Decomposition(mesh) => mesh.points(),
            Self::Compound(parts) => parts.iter().map(|p| p.shape.points()).sum(),
            _ => 1.0,
        }
    }

    /// Why no such shape can be made, as far as that shows before it is tried.
    pub(crate) fn complaint(&self) -> Option<&'static str> {
        match self {
            Self::HalfSpace { normal } => {
                let normal = Vector::from_array(normal.map(|x| x as Real));
                let none = normal.try_normalize().is_none();
                none.then_some("the normal has no length")
            }
            Self::Polyline { points } if points.len() < 2 => Some("a polyline needs two points"),
            Self::Hull { points, .. } if points.len() > MOST_OF_A_HULL => {
                Some("a hull has at most ten thousand points")
            }
            Self::Decomposition(mesh) if mesh.points() > MOST_TO_CUT => {
                Some("a surface of more than a hundred thousand points is not cut into parts")
            }
            Self::HeightField { heights, .. } => field(heights),
            Self::Voxels { size, points } => voxels(size, points),
            Self::Compound(parts) => parts.iter().find_map(|p| match p.shape.is_composite() {
                true => Some(
                    "a part of a compound can't itself be a compound, a mesh, a ground or a polyline",
                ),
                false => p.shape.complaint(),
            }),
            _ => None,
        }
    }

    /// Whether it is made of other shapes.
    fn is_composite(&self) -> bool {
        matches!(
            self,
            Self::Polyline { .. }
                | Self::TriMesh(_)
                | Self::HeightField { .. }
                | Self::Terrain { .. }
                | Self::Decomposition(_)
                | Self::Voxels { .. }
                | Self::Compound(_)
        )
    }
}

fn field(heights: &[Vec<f64>]) -> Option<&'static str> {
    let columns = heights.first().map_or(0, Vec::len);
    if heights.len() < 2 || columns < 2 {
        return Some("a height field needs two rows and two columns");
    }
    let uneven = heights.iter().any(|row| row.len() != columns);
    uneven.then_some("the rows of a height field must be of one length")
}

fn voxels(size: &[f64; 3], points: &[[f64; 3]]) -> Option<&'static str> {
    if points.is_empty() {
        return Some("voxels need a point");
    }
    // Their coordinates are counted in `i32`, with room for neighbours.
    let far = |p: &[f64; 3]| {
        p.iter()
            .zip(size)
            .any(|(x, side)| (x / side).abs() >= 1.0e9)
    };
    let any = points.iter().any(far);
    any.then_some("a voxel must be less than a thousand million sizes from the middle")
}

impl Mesh {
    /// Its forms, for the reference.
    pub(crate) const KEYS: &'static [Entry] = &[
        Entry {
            owner: "Mesh",
            key: "",
            kind: "choice",
            default: "",
            doc: "A surface: `Hatchback`, the path of an OBJ file in quotes, `Ball(radius: …)`, or its own points and triangles.",
        },
        Entry {
            owner: "Mesh",
            ..explicit::Points::KEYS[1]
        },
        Entry {
            owner: "Mesh",
            ..explicit::Points::KEYS[2]
        },
        explicit::Ball::KEYS[0],
        explicit::Ball::KEYS[1],
        explicit::Ball::KEYS[2],
        explicit::Ball::KEYS[3],
    ];
}
