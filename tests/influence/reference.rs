//! Random scenes with the reference adapter. `DECOR_INFLUENCE_SCENES` of them
//! (default 2 000), half of them antialiased; those with the depth of all
//! samples, and with that of the centres alone.

use std::sync::Mutex;

use decor_api::{Antialias, BLOCK, Output, PrototypeTable, RunContext, Size};
use decor_reference::Reference;
use rayon::prelude::*;

use crate::count;
use crate::scenes::{Dice, differing, random, render};

const SIZE: Size = Size {
    width: 48,
    height: 36,
};

#[derive(Default)]
struct Totals {
    differing: usize,
    influenced: usize,
    missed: Vec<String>,
}

fn check(number: u64, share: f64) -> [Totals; 4] {
    let mut table = PrototypeTable::default();
    let mut dice = Dice(0xdec0_0000 + number);
    let mut case = random(&mut dice, &mut table, SIZE);
    let per_side = 2 + (number / 2 % 2) as u32;
    case.antialias = (number % 2 == 1).then_some(Antialias {
        threshold: 0.05,
        depth: per_side,
    });
    let (adapter, run) = (Reference::new(), RunContext::new(std::env::temp_dir()));
    let drawn = |scene, size, output| {
        let antialias = case.antialias;
        let layers = render(&adapter, &run, &table, vec![scene], size, output, antialias);
        layers.into_iter().next().unwrap()
    };
    let full = drawn(case.scene.clone(), SIZE, Output::ColourOverBackground);
    let decor = drawn(case.decor(), SIZE, Output::ColourOverBackground);
    let changed = differing(&full, &decor, SIZE);
    let mut totals = <[Totals; 4]>::default();
    let mut compare = |place: usize, mask: &decor::influence::Mask, by_blocks: Option<u32>| {
        let total = &mut totals[place];
        total.differing += changed.len();
        total.influenced += mask.count();
        let mask = if case.antialias.is_some() {
            mask.dilated()
        } else {
            mask.clone()
        };
        let blocks = by_blocks.map(|side| mask.blocks(side));
        let has = |x, y| match &blocks {
            Some(blocks) => blocks.has_pixel(x, y),
            None => mask.contains(x, y),
        };
        let missed = changed.iter().filter(|(x, y)| !has(*x, *y));
        let missed: Vec<_> = missed.collect();
        if let Some((x, y)) = missed.first() {
            let count = missed.len();
            let text = format!("scene {number}: {count} pixels, the first at ({x}, {y})");
            total.missed.push(text);
        }
    };
    let of = |samples, by_blocks| {
        let depth = &decor;
        case.mask_of_smaller(share, &table, depth, samples, by_blocks)
    };
    if case.antialias.is_none() {
        compare(0, &of(None, None), None);
        // Every block side that a renderer may have.
        let side = Some([4, 8, 16, BLOCK][(number / 2 % 4) as usize]);
        compare(3, &of(None, side), side);
    } else {
        let fine = Size {
            width: SIZE.width * per_side,
            height: SIZE.height * per_side,
        };
        let samples = drawn(case.decor(), fine, Output::Depth);
        let samples = Some((&samples, per_side));
        compare(1, &of(samples, None), None);
        compare(2, &of(None, None), None);
        let by_blocks = of(samples, Some(BLOCK));
        compare(3, &by_blocks, Some(BLOCK));
        // It is only quicker: no block is there that the whole mask has not.
        let blocks = |mask: &decor::influence::Mask| mask.dilated().blocks(BLOCK);
        let more = blocks(&by_blocks).without(&blocks(&of(samples, None)));
        assert!(more.is_empty(), "scene {number}: {:?}", more.numbers());
    }
    totals
}

#[test]
fn every_pixel_that_differs_is_influenced() {
    let all = Mutex::new(<[Totals; 4]>::default());
    (0..count("DECOR_INFLUENCE_SCENES", 2000))
        .into_par_iter()
        .for_each(|number| {
            let found = check(number, 1.0);
            let mut all = all.lock().unwrap();
            for (all, found) in all.iter_mut().zip(found) {
                all.differing += found.differing;
                all.influenced += found.influenced;
                all.missed.extend(found.missed);
            }
        });
    let all = all.into_inner().unwrap();
    let names = ["centres", "samples", "neighbourhoods", "blocks"];
    for (name, total) in names.iter().zip(&all) {
        println!(
            "{name}: {} pixels differ, {} are influenced, {} scenes fail {:?}",
            total.differing,
            total.influenced,
            total.missed.len(),
            &total.missed[..total.missed.len().min(8)]
        );
        assert!(total.differing > 10_000, "{name}: too little changes");
    }
    assert!(all.iter().all(|total| total.missed.is_empty()), "see above");
}

/// The test above would notice: spheres one part in twenty too small miss pixels.
#[test]
fn a_mask_that_is_too_small_is_found_out() {
    let missed = (0..100_u64).into_par_iter().map(|number| {
        let found = check(number, 0.95);
        found.map(|total| total.missed.len())
    });
    let sums = missed.reduce(|| [0; 4], |a, b| std::array::from_fn(|i| a[i] + b[i]));
    println!("centres, samples, neighbourhoods, blocks: {sums:?} scenes fail");
    assert!(sums[0] > 0 && sums[1] > 0, "{sums:?}");
}
