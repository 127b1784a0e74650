//! Random scenes with POV-Ray, as its own adapter writes them.
//! `DECOR_INFLUENCE_POVRAY` of them (default 24), half of them antialiased.

use decor::influence::Mask;
use decor_api::{Adapter, Antialias, BLOCK, Layer, Output, PrototypeTable, RunContext, Size};
use decor_povray::{LayerSource, PovRay};
use rayon::prelude::*;

use crate::count;
use crate::scenes::{Case, Dice, differing, random, render};

const SIZE: Size = Size {
    width: 112,
    height: 80,
};

/// Scenes in one call.
const BATCH: u64 = 6;

/// Samples along a pixel's side.
const PER_SIDE: u32 = 3;

struct Outcome {
    differing: usize,
    influenced: usize,
    outside_mask: usize,
    outside_blocks: usize,
    text: String,
}

fn judge(mask: &Mask, changed: &[(u32, u32)], text: String) -> Outcome {
    let dilated = mask.dilated();
    let blocks = dilated.blocks(BLOCK);
    let window = |&(x, y): &(u32, u32)| decor_api::Window {
        x,
        y,
        width: 1,
        height: 1,
    };
    let outside: Vec<_> = changed
        .iter()
        .filter(|(x, y)| !dilated.contains(*x, *y))
        .collect();
    Outcome {
        differing: changed.len(),
        influenced: mask.count(),
        outside_mask: outside.len(),
        outside_blocks: changed
            .iter()
            .filter(|p| !blocks.contains(window(p)))
            .count(),
        text: format!("{text}: {} pixels {:?}", outside.len(), outside.first()),
    }
}

fn batch(adapter: &dyn Adapter, first: u64, antialiased: bool) -> Vec<[Option<Outcome>; 2]> {
    let mut table = PrototypeTable::default();
    let antialias = antialiased.then_some(Antialias {
        threshold: 0.1,
        depth: PER_SIDE,
    });
    let cases: Vec<Case> = (first..first + BATCH)
        .map(|number| {
            let mut case = random(&mut Dice(0x90f_0000 + number), &mut table, SIZE);
            case.antialias = antialias;
            case
        })
        .collect();
    let folder = tempfile::tempdir().expect("a temporary folder");
    let run = RunContext::new(folder.path());
    // A call's frames are with shadows, or without; and a depth of its own keeps
    // a scene's range.
    let drawn = |decor: bool, size: Size, output: Output| -> Vec<Layer> {
        let scenes = cases.iter().map(|case| {
            let mut scene = if decor {
                case.decor()
            } else {
                case.scene.clone()
            };
            scene.shadows = true;
            scene
        });
        let antialias = antialias.filter(|_| output != Output::Depth);
        render(
            adapter,
            &run,
            &table,
            scenes.collect(),
            size,
            output,
            antialias,
        )
    };
    let full = drawn(false, SIZE, Output::ColourOverBackground);
    let decor = drawn(true, SIZE, Output::ColourOverBackground);
    let depth = drawn(true, SIZE, Output::Depth);
    let fine = Size {
        width: SIZE.width * PER_SIDE,
        height: SIZE.height * PER_SIDE,
    };
    let samples = antialiased.then(|| drawn(true, fine, Output::Depth));
    cases
        .into_iter()
        .enumerate()
        .map(|(k, mut case)| {
            case.scene.shadows = true;
            let changed = differing(&full[k], &decor[k], SIZE);
            let text = format!("scene {} antialiased {antialiased}", first + k as u64);
            let mask = case.mask(&table, &depth[k], None);
            let exact = samples.as_ref().map(|samples| {
                let mask = case.mask(&table, &depth[k], Some((&samples[k], PER_SIDE)));
                judge(&mask, &changed, format!("{text}, samples"))
            });
            [Some(judge(&mask, &changed, text)), exact]
        })
        .collect()
}

#[test]
fn every_pixel_that_differs_is_influenced() {
    let adapter = PovRay::find()
        .expect("POV-Ray is installed")
        .with_source(LayerSource::StateFile);
    let scenes = count("DECOR_INFLUENCE_POVRAY", 24);
    let batches: Vec<u64> = (0..scenes.div_ceil(BATCH)).collect();
    let outcomes: Vec<Outcome> = batches
        .into_par_iter()
        .flat_map_iter(|k| batch(&adapter, k * BATCH, k % 2 == 1))
        .flat_map_iter(|pair| pair.into_iter().flatten())
        .collect();
    let sum = |what: fn(&Outcome) -> usize| outcomes.iter().map(what).sum::<usize>();
    println!(
        "{} pixels differ, {} are influenced; {} outside of the mask, {} of the blocks",
        sum(|o| o.differing),
        sum(|o| o.influenced),
        sum(|o| o.outside_mask),
        sum(|o| o.outside_blocks)
    );
    for outcome in outcomes.iter().filter(|o| o.outside_mask > 0) {
        println!("{}", outcome.text);
    }
    assert!(sum(|o| o.differing) > 5_000, "too little changes");
    assert_eq!(sum(|o| o.outside_blocks), 0);
    assert_eq!(sum(|o| o.outside_mask), 0);
}
