//! The ellipse and both measures against tables made with 80 digits
//! (`scripts/motion-reference.py`).

use decor::motion::{
    Lenses, RelativeMotion, bound_px, project_sphere, thesis, thesis::semi_axes_by_foci,
};
use glam::{DVec2, DVec3};

fn table(text: &str) -> impl Iterator<Item = Vec<f64>> {
    text.lines().skip(1).map(|line| {
        line.split(',')
            .map(|field| field.parse().expect("a number"))
            .collect()
    })
}

#[test]
fn the_axes_keep_their_digits() {
    let mut worst = [0.0_f64; 3];
    let mut foci = std::collections::BTreeMap::new();
    let mut rows = 0;
    for row in table(include_str!("../fixtures/motion/ellipses.csv")) {
        let (c, radius) = (DVec3::new(row[0], row[1], row[2]), row[3]);
        let e = *project_sphere(c, radius).ellipse().expect("in front");
        let centre = DVec2::new(row[4], row[5]);
        let scale = if centre.length() > 0.0 {
            centre.length()
        } else {
            1.0
        };
        let off = [
            (e.centre - centre).length() / scale,
            (e.semi_major / row[6] - 1.0).abs(),
            (e.semi_minor / row[7] - 1.0).abs(),
        ];
        for i in 0..3 {
            worst[i] = worst[i].max(off[i]);
            assert!(off[i] <= 1e-12, "{off:?} at {row:?}");
        }
        if let Some((a, _)) = semi_axes_by_foci(c, radius) {
            let exponent = (radius / c.length()).log10().round() as i32;
            let entry = foci.entry(-exponent).or_insert(0.0_f64);
            *entry = entry.max((a / row[6] - 1.0).abs());
        }
        rows += 1;
    }
    println!(
        "{rows} spheres: relative error of the centre {:.1e}, semi-major axis {:.1e}, semi-minor axis {:.1e}",
        worst[0], worst[1], worst[2]
    );
    for (exponent, off) in foci {
        println!(
            "R/D about 1e-{exponent}: semi-major axis by the thesis's foci off by {off:.0e}, where they give one"
        );
    }
}

#[test]
fn both_measures_agree_with_many_digits() {
    let mut worst = [0.0_f64; 4];
    let mut rows = 0;
    for row in table(include_str!("../fixtures/motion/measures.csv")) {
        let three = |i: usize| DVec3::new(row[i], row[i + 1], row[i + 2]);
        let motion = RelativeMotion::in_camera_space(three(0), three(3), three(6), row[9]);
        let lenses = Lenses::zoom(DVec2::splat(row[10]), DVec2::splat(row[11]));
        let measure = thesis(&motion, &lenses).expect("in front");
        let (translation, rotation, bound) = (row[12], row[13], row[14]);
        // Two positions are subtracted here: rounding is that of the positions.
        let absolute = (measure.translation_px - translation).abs();
        let turned = if rotation == 0.0 {
            measure.rotation_px
        } else {
            (measure.rotation_px / rotation - 1.0).abs()
        };
        let excess = bound_px(&motion, &lenses) / bound - 1.0;
        worst = [
            worst[0].max(absolute),
            worst[1].max(turned),
            worst[2].max(excess),
            worst[3].max(-excess),
        ];
        assert!(
            absolute < 1e-12 * row[10].max(row[11]) * 20.0,
            "{absolute} at {row:?}"
        );
        assert!(turned < 1e-6, "{turned} at {row:?}");
        let px = excess * bound;
        assert!(
            excess >= 0.0 && px <= 1e-10 * bound + 1e-13 * row[10],
            "{excess} at {row:?}"
        );
        rows += 1;
    }
    println!(
        "{rows} motions: thesis's translation off by {:.1e} px at most, its rotation by {:.1e} of \
         itself; the bound above its exact formula by {:.1e} of itself at most, below it by {:.1e}",
        worst[0], worst[1], worst[2], worst[3]
    );
}
