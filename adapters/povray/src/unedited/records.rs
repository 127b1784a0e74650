//! What an instrumented copy writes of a scene: a line a frame, an object, a part of
//! one, a light, a camera.

use glam::DVec3;

use super::boxes::{Extent, FrameBoxes, Placed};

/// POV-Ray calls an extent without end ±1e10.
const ENDLESS: f64 = 9e9;

/// Extents are kept in single precision, a corner and a length each, and are
/// moved and turned as such: this share of the largest coordinate covers it.
const ROUNDING: f64 = 2e-6;

/// And this, what is written with twelve digits behind the point.
const LEAST: f64 = 1e-9;

/// Lights' centres are known to this share of their coordinates.
const LIGHT_TOLERANCE: f64 = 1e-6;

/// Parts stand for a union where their boxes have at most this share of its surface:
/// each of them costs time in every pass.
const MOST_SURFACE: f64 = 0.75;

/// A frame as it is read.
#[derive(Default)]
pub(super) struct Frame {
    pub boxes: FrameBoxes,
    /// Has all of it been read?
    pub whole: bool,
    cameras: usize,
    /// The parts of the union that was read last.
    parts: Vec<Placed>,
}

/// The frames of what was written.
pub(super) fn frames(said: &str) -> Vec<Frame> {
    said.lines().collect::<Reading>().frames
}

/// All frames as they are read; what cannot be read leaves its frame not whole.
#[derive(Default)]
struct Reading {
    frames: Vec<Frame>,
}

impl<'l> FromIterator<&'l str> for Reading {
    fn from_iter<I: IntoIterator<Item = &'l str>>(lines: I) -> Self {
        let mut reading = Self::default();
        let mut broken = false;
        for line in lines {
            let mut words = line.split_whitespace();
            let kind = words.next().unwrap_or_default();
            let words: Vec<&str> = words.collect();
            if kind == "F" {
                broken = false;
                let frame = words.first().and_then(|n| n.parse().ok());
                reading.frames.push(Frame::default());
                if let (Some(frame), Some(last)) = (frame, reading.frames.last_mut()) {
                    last.boxes.frame = frame;
                    // No camera is POV-Ray's own.
                    last.boxes.camera = Some(Vec::new());
                }
                continue;
            }
            let Some(frame) = reading.frames.last_mut() else {
                continue;
            };
            broken |= frame.read(kind, &words).is_none();
            frame.whole = kind == "E" && !broken;
        }
        reading
    }
}

impl Frame {
    /// The union that was read last is its parts, where they are less than its box.
    fn settle(&mut self) {
        let parts = std::mem::take(&mut self.parts);
        let is_less = |whole: &mut Placed| is_less(whole, &parts);
        if self.boxes.objects.pop_if(is_less).is_some() {
            self.boxes.objects.extend(parts);
        }
    }

    fn read(&mut self, kind: &str, words: &[&str]) -> Option<()> {
        let is_part = matches!(kind, "o" | "r");
        if !is_part {
            self.settle();
        }
        match kind {
            "O" | "R" | "P" | "o" | "r" => {
                let statement = words.first()?.parse().ok()?;
                let points = vectors(&words[1..])?;
                let extent = match *points.as_slice() {
                    [min, max] => extent(min, max),
                    [min, max, ..] => plane(&points[2..])
                        .filter(|_| is_endless(min, max))
                        .unwrap_or_else(|| extent(min, max)),
                    _ => return None,
                };
                let placed = Placed {
                    statement,
                    extent,
                    round: matches!(kind, "R" | "r"),
                };
                if is_part {
                    self.parts.push(placed);
                } else {
                    self.boxes.objects.push(placed);
                }
            }
            "L" => {
                let points = vectors(words.get(1..)?)?;
                let [a, b] = points[..] else { return None };
                if a.is_finite()
                    && (a - b).abs().max_element() <= LIGHT_TOLERANCE * (1.0 + b.length())
                {
                    self.boxes.lights.push(b);
                } else {
                    // Too far away, or out of shape.
                    self.boxes.lost_light = true;
                }
            }
            "C" => {
                self.cameras += 1;
                if self.cameras > 1 || words.contains(&"?") {
                    self.boxes.camera = None;
                }
                if let Some(camera) = &mut self.boxes.camera {
                    for word in words.chunks(4) {
                        let value = *vectors(word.get(1..)?)?.first()?;
                        camera.push((word[0].to_owned(), value));
                    }
                }
            }
            "E" => {}
            _ => return None,
        }
        Some(())
    }
}

/// Have the parts of something so little surface that they stand for it?
fn is_less(whole: &Placed, parts: &[Placed]) -> bool {
    let area = |placed: &Placed| match placed.extent {
        Extent::Box { min, max } => {
            let sides = max - min;
            sides.x * sides.y + sides.y * sides.z + sides.z * sides.x
        }
        _ => f64::INFINITY,
    };
    let sum: f64 = parts.iter().map(area).sum();
    let is_box = matches!(whole.extent, Extent::Box { .. });
    is_box && !parts.is_empty() && sum <= area(whole) * MOST_SURFACE
}

fn vectors(words: &[&str]) -> Option<Vec<DVec3>> {
    let numbers: Vec<f64> = words
        .iter()
        .map(|word| word.parse().ok())
        .collect::<Option<_>>()?;
    let whole = numbers.len().is_multiple_of(3);
    whole.then(|| numbers.chunks(3).map(DVec3::from_slice).collect())
}

fn is_endless(min: DVec3, max: DVec3) -> bool {
    let largest = min.abs().max_element().max(max.abs().max_element());
    // What is not a number has no end either.
    !(largest < ENDLESS && min.is_finite() && max.is_finite())
}

fn extent(a: DVec3, b: DVec3) -> Extent {
    if is_endless(a, b) {
        return Extent::Endless;
    }
    // A sphere of a negative radius is one, and its box is the wrong way round.
    let (min, max) = (a.min(b), a.max(b));
    let largest = min.abs().max_element().max(max.abs().max_element());
    let room = DVec3::splat(largest * ROUNDING + LEAST);
    Extent::Box {
        min: min - room,
        max: max + room,
    }
}

/// Three rays along the axes: where they hit, and the normal there (none: 0).
fn plane(rays: &[DVec3]) -> Option<Extent> {
    let mut hits = rays
        .chunks(2)
        .filter(|hit| hit.len() == 2 && hit[1].length() > 0.5);
    let hit = hits.next()?;
    Some(Extent::Plane {
        point: hit[0],
        normal: hit[1].normalize(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_read() {
        let frames = frames(
            "F 3\nO 0 -1 -1 -1 1 1 2\nL 2 1 2 3 1 2 3\nC location 0 1 2 angle 40 40 40\n\
             P 1 -1e10 -1e10 -1e10 1e10 1e10 1e10 0 0 0 0 0 0 1 5 1 0 1 0 0 0 0 0 0 0\nE\nF 4\nE\n",
        );
        assert!(frames.iter().all(|frame| frame.whole));
        let frame = &frames[0].boxes;
        assert_eq!(
            (frame.frame, frame.lights.as_slice()),
            (3, &[DVec3::new(1.0, 2.0, 3.0)][..])
        );
        let camera = frame.camera.as_ref().expect("it is plain");
        assert_eq!(camera[1], ("angle".into(), DVec3::splat(40.0)));
        let Extent::Box { min, max } = frame.objects[0].extent else {
            panic!("it has an end")
        };
        assert!(min.z < -1.0 && max.z > 2.0 && max.z < 2.0001);
        let plane = Extent::Plane {
            point: DVec3::new(1.0, 5.0, 1.0),
            normal: DVec3::Y,
        };
        assert_eq!(frame.objects[1].extent, plane);
        assert_eq!(frames[1].boxes.camera, Some(Vec::new()));
        let turned = &super::frames("F 1\nO 0 1 1 1 -1 -1 -2\nE\n")[0].boxes;
        assert_eq!(
            turned.objects[0].extent,
            extent(DVec3::new(-1.0, -1.0, -2.0), DVec3::ONE)
        );
    }

    #[test]
    fn parts_stand_for_a_union_that_is_mostly_empty() {
        let read = |whole: &str, parts: &str| {
            let found = frames(&format!("F 1\nO 0 0 0 0 1 1 1\n{whole}\n{parts}E\n"));
            assert!(found[0].whole, "{whole} {parts}");
            let boxes = found[0].boxes.objects[1..].iter();
            let flags = boxes.map(|placed| (placed.statement, placed.round));
            flags.collect::<Vec<_>>()
        };
        let (wide, two) = ("O 7 0 0 0 9 1 1", "o 7 0 0 0 1 1 1\nr 7 8 0 0 9 1 1\n");
        assert_eq!(read(wide, two), [(7, false), (7, true)]);
        // Two halves have more surface than the whole.
        let halves = "o 7 0 0 0 5 1 1\no 7 5 0 0 9 1 1\n";
        assert_eq!(read(wide, halves), [(7, false)]);
        assert_eq!(read(wide, "o 7 0 0 0 1e10 1 1\n"), [(7, false)]);
        assert_eq!(read("O 7 0 0 0 1e10 1 1", two), [(7, false)]);
        assert_eq!(read("R 7 0 0 0 1 1 1", ""), [(7, true)]);
    }

    #[test]
    fn what_cannot_be_read_is_not_whole() {
        for text in [
            "F 1\nO 0 1 2\nE\n",
            "F 1\nO 0 nan x 0 0 0 0\nE\n",
            "F 1\n",
            "F 1\nQ\nE\n",
        ] {
            assert!(!frames(text)[0].whole, "{text}");
        }
        assert_eq!(
            frames("F 1\nO 0 nan 0 0 0 0 0\nE\n")[0].boxes.objects[0].extent,
            Extent::Endless
        );
        assert_eq!(frames("F 1\nC ?\nE\n")[0].boxes.camera, None);
        assert_eq!(
            frames("F 1\nC up 0 1 0\nC up 0 1 0\nE\n")[0].boxes.camera,
            None
        );
        assert!(frames("F 1\nL 0 1 2 3 1 2 4\nE\n")[0].boxes.lost_light);
        assert!(!frames("F 1\nL 0 1 2 3 1 2 3\nE\n")[0].boxes.lost_light);
    }
}
