//! What is in force, carried on: the prediction of a stream that arrives scene
//! by scene.

use std::collections::HashMap;

use glam::DVec3;

use super::frame::{Now, Since};
use super::model::{Moving, ObjectId, Placed};

impl Now {
    /// The same, stated in frame `number`: every value is the one that it has
    /// there, bit for bit.
    pub(super) fn since(&self, number: u32) -> Self {
        let point = |point: &Since<Moving>| Since {
            frame: number,
            value: Moving {
                position: point.at(number),
                velocity: point.value.velocity,
            },
        };
        let steps = number.saturating_sub(self.objects.frame);
        let objects = self.objects.value.iter().map(|placed| Placed {
            pose: placed.pose_after(steps),
            ..*placed
        });
        let mut now = self.clone();
        (now.view.eye, now.view.aim) = (point(&self.view.eye), point(&self.view.aim));
        now.objects = Since {
            frame: number,
            value: objects.collect(),
        };
        now
    }

    /// Replaces velocities of this scene, which begins in frame `number`, that
    /// stay what they were `before`, in frame `from`, and were wrong about the
    /// way from there to here.
    pub(super) fn believe(&mut self, before: &Self, from: u32, number: u32) {
        let steps = f64::from(number - from);
        for (point, before) in [
            (&mut self.view.eye, &before.view.eye),
            (&mut self.view.aim, &before.view.aim),
        ] {
            let Moving { position, velocity } = &mut point.value;
            let same = *velocity == before.value.velocity;
            if same && *position != before.at(number) {
                *velocity = (*position - before.at(from)) / steps;
            }
        }
        let then: HashMap<ObjectId, &Placed> =
            before.objects.value.iter().map(|p| (p.object, p)).collect();
        let since = before.objects.frame;
        let believed = |placed: &Placed| {
            let mut placed = *placed;
            let Some(then) = then.get(&placed.object) else {
                return placed;
            };
            let expected = then.pose_after(number.saturating_sub(since));
            let was = then.pose_after(from.saturating_sub(since));
            if placed.motion == then.motion && placed.pose != expected {
                placed.motion.velocity = (placed.pose.position - was.position) / steps;
                let turned = (placed.pose.angles_deg - was.angles_deg).map(shorter);
                placed.motion.angles_velocity_deg = turned / steps;
            }
            placed
        };
        self.objects.value = self.objects.value.iter().map(believed).collect();
    }

    /// The last frame from `number` to `last` up to which all can be predicted:
    /// there is a camera, and places are numbers.
    pub(super) fn lasts(&self, number: u32, last: u32) -> u32 {
        let steps = last - number;
        let finite = |v: DVec3| v.is_finite();
        let places = self.objects.value.iter().all(|placed| {
            let pose = placed.pose_after(steps);
            finite(pose.position) && finite(pose.angles_deg)
        });
        if !places {
            return number;
        }
        let ends = (number + 1..=last).find(|&n| self.view.camera(n).is_err());
        ends.map_or(last, |n| n - 1)
    }
}

/// The same turn in degrees, from −180 to 180.
fn shorter(degrees: f64) -> f64 {
    degrees - 360.0 * (degrees / 360.0).round()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use crate::film::FilmStream;

    fn stream(lines: &[String]) -> FilmStream {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/plane");
        let mut stream = FilmStream::new("lines", &folder, false);
        for line in lines {
            stream.push_line(line.as_bytes()).unwrap();
        }
        stream
    }

    fn line(number: u32, x: f64, angle: f64, velocity: f64) -> String {
        format!(
            r#"{{"scene":{number},"size":[32,24],"angles":[60,45],
            "eye":{{"position":[{x},0,-9],"velocity":[{velocity},0,0]}},"aim":{{"position":[0,0,0]}},
            "objects":[{{"path":"plane","position":[{x},0,0],"angles":[0,{angle},0],
            "velocity":[{velocity},0,0]}}]}}"#
        )
        .replace('\n', "")
    }

    #[test]
    fn what_is_stated_is_believed_until_it_is_wrong() {
        // Nothing is known but the first scene.
        let first = stream(&[line(3, 1.0, 0.0, 0.5)]).predicted(3, 9).unwrap();
        assert_eq!(first.frames(), 3..=9);
        assert_eq!(first.frame(7).objects[0].pose.position.x, 3.0);
        assert_eq!(first.frame(7).camera.eye.x, 3.0);
        // It was right; it was wrong but is another now; it was wrong and is
        // the same.
        let next = |x, velocity| {
            stream(&[line(3, 1.0, 350.0, 0.5), line(5, x, 350.0, velocity)])
                .predicted(5, 9)
                .unwrap()
        };
        for (x, velocity, later) in [(2.0, 0.5, 2.5), (7.0, 0.25, 7.25), (7.0, 0.5, 10.0)] {
            let film = next(x, velocity);
            assert_eq!(film.frame(5).objects[0].pose.position.x, x);
            assert_eq!(film.frame(6).objects[0].pose.position.x, later);
            assert_eq!(film.frame(6).camera.eye.x, later);
        }
    }

    #[test]
    fn a_turn_goes_the_shorter_way() {
        let film = stream(&[line(0, 0.0, 350.0, 0.0), line(1, 0.0, 4.0, 0.0)]).predicted(1, 2);
        let film = film.unwrap();
        assert_eq!(film.frame(2).objects[0].pose.angles_deg.y, 18.0);
    }

    #[test]
    fn a_prediction_ends_where_the_observer_reaches_the_aim() {
        let text = r#"{"scene":0,"size":[32,24],"angles":[60,45],
            "eye":{"position":[0,0,-3],"velocity":[0,0,1]},"aim":{"position":[0,0,0]}}"#;
        let film = stream(&[text.replace('\n', "")]).predicted(0, 50).unwrap();
        assert_eq!(film.frames(), 0..=2);
    }

    #[test]
    fn frames_between_scenes_are_predicted_by_the_scene_before_them() {
        let stream = stream(&[line(0, 0.0, 0.0, 0.1), line(4, 9.0, 0.0, 0.3)]);
        let between = stream.predicted(3, 6).unwrap();
        assert_eq!(between.frames(), 3..=6);
        assert_eq!(between.frame(3), stream.frame(3).unwrap());
        assert_eq!(between.frame(6).objects[0].motion.velocity.x, 0.1);
    }
}
