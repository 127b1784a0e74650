//! What is ruled out before any depth is known, and what is left out of blocks, is
//! never missed: random scenes with the reference.

use decor::influence::{
    Changed, Depths, Influence, Places, Ranges, Solid, Still, influence, matters, parts, reach,
    shades, with_ring,
};
use decor::motion::screen_box;
use decor::plan::{BLOCK, BlockSet};
use decor_api::{
    Antialias, Bounds, Instance, Layer, Output, PrototypeTable, RunContext, Scene, Size, Window,
};
use decor_reference::Reference;
use rayon::prelude::*;

use crate::count;
use crate::scenes::{Case, Dice, differing, random, render, smaller};

/// Some blocks, of which most scenes leave some alone.
const SIZE: Size = Size {
    width: 160,
    height: 128,
};

const PER_SIDE: u32 = 2;

/// A random case with its pictures.
struct Drawn {
    case: Case,
    table: PrototypeTable,
    full: Layer,
    decor: Layer,
    samples: Option<Layer>,
}

/// The side of the blocks that are drawn.
fn side(case: &Case) -> u32 {
    if case.antialias.is_some() { BLOCK } else { 8 }
}

fn picture(case: &Case, table: &PrototypeTable, scene: Scene, size: Size, what: Output) -> Layer {
    let (adapter, run) = (Reference::new(), RunContext::new(std::env::temp_dir()));
    let antialias = case.antialias.filter(|_| what != Output::Depth);
    let layers = render(&adapter, &run, table, vec![scene], size, what, antialias);
    layers.into_iter().next().unwrap()
}

impl Drawn {
    fn new(number: u64) -> Self {
        let mut table = PrototypeTable::default();
        let mut case = random(&mut Dice(0x4ea_0000 + number), &mut table, SIZE);
        case.antialias = (number % 2 == 1).then_some(Antialias {
            threshold: 0.05,
            depth: PER_SIDE,
        });
        let fine = Size {
            width: SIZE.width * PER_SIDE,
            height: SIZE.height * PER_SIDE,
        };
        let colour = Output::ColourOverBackground;
        Self {
            full: picture(&case, &table, case.scene.clone(), SIZE, colour),
            decor: picture(&case, &table, case.decor(), SIZE, colour),
            samples: case
                .antialias
                .map(|_| picture(&case, &table, case.decor(), fine, Output::Depth)),
            case,
            table,
        }
    }

    /// What is placed, or something smaller: then the answers are wrong.
    fn changed(&self, instance: &Instance, share: f64) -> Changed {
        let prototype = self.table.get(instance.prototype);
        let mut object = Changed::placed(prototype, &parts(prototype), &instance.pose);
        object.parts.iter_mut().for_each(|p| p.radius *= share);
        let extents = prototype.extents.iter().map(|e| smaller(e, share));
        object.boxes = extents.map(|e| Solid::placed(&e, &instance.pose)).collect();
        if let Bounds::Sphere(whole) = &mut object.whole {
            whole.radius *= share;
        }
        object
    }

    fn all(&self, instances: &[Instance], share: f64) -> Vec<Changed> {
        instances.iter().map(|i| self.changed(i, share)).collect()
    }

    fn depths(&self) -> Depths<'_> {
        match &self.samples {
            Some(samples) => Depths::with_samples(&self.decor, samples, PER_SIDE),
            None => Depths::at_centres(&self.decor),
        }
    }

    fn still<'a>(&'a self, depths: Depths<'a>, optical: &'a [Window]) -> Still<'a> {
        Still {
            camera: &self.case.scene.camera,
            size: SIZE,
            lights: &self.case.scene.lights,
            shadows: self.case.scene.shadows,
            antialiased: self.case.antialias.is_some(),
            by_blocks: Some(side(&self.case)),
            depths,
            optical,
            slender: &[],
        }
    }

    fn is_optical(&self, instance: &&Instance) -> bool {
        self.table.get(instance.prototype).optics.is_optical()
    }
}

/// How many pixels differ, how many blocks are left alone, and pixels that were
/// missed.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    differing: usize,
    left_alone: usize,
    missed: usize,
}

impl std::ops::Add for Sums {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            differing: self.differing + other.differing,
            left_alone: self.left_alone + other.left_alone,
            missed: self.missed + other.missed,
        }
    }
}

fn sums(share: f64, usual: u64, check: fn(u64, f64) -> Sums) -> Sums {
    // A tenth of the others: these pictures are larger.
    let scenes = (0..count("DECOR_INFLUENCE_SCENES", 10 * usual) / 10).into_par_iter();
    let found = scenes.map(|number| check(number, share));
    found.reduce(Sums::default, |a, b| a + b)
}

fn reached(number: u64, share: f64) -> Sums {
    let drawn = Drawn::new(number);
    let (decor, moving) = drawn.case.scene.instances.split_at(drawn.case.decor_count);
    let moving = drawn.all(moving, share);
    let receivers = drawn.all(decor, share);
    let mirrors = decor.iter().filter(|i| drawn.is_optical(i));
    let optical: Vec<Window> = mirrors
        .map(|i| {
            let bounds = drawn.table.get(i.prototype).bounds.posed(&i.pose);
            screen_box(&bounds, &drawn.case.scene.camera, SIZE).window()
        })
        .collect();
    let unknown = drawn.still(Depths::unknown(), &[]);
    let Some(reached) = reach(&unknown, &moving, &receivers) else {
        return Sums::default();
    };
    let plain = drawn.depths().within(&reached, &reached);
    let ranges = Ranges::of(&plain, SIZE, drawn.case.antialias.is_some());
    let still = drawn.still(plain.with_ranges(&ranges), &optical);
    let Influence::Confined(mask) = influence(&still, &moving, None) else {
        panic!("everything has an end");
    };
    let around = u32::from(drawn.case.antialias.is_some());
    let blocks = mask.blocks_around(side(&drawn.case), around, None);
    let changed = differing(&drawn.full, &drawn.decor, SIZE);
    let missed = changed.iter().filter(|(x, y)| !blocks.has_pixel(*x, *y));
    let mut all = BlockSet::none(SIZE, BLOCK);
    all.insert(SIZE.window());
    Sums {
        missed: missed.count(),
        differing: changed.len(),
        left_alone: all.numbers().len() - reached.numbers().len(),
    }
}

fn left_out(number: u64, share: f64) -> Sums {
    let drawn = Drawn::new(number);
    let instances = &drawn.case.scene.instances;
    if instances.iter().any(|i| drawn.is_optical(&i)) {
        return Sums::default();
    }
    let (decor, moving) = instances.split_at(drawn.case.decor_count);
    let moving = drawn.all(moving, 1.0);
    let mut known = BlockSet::none(SIZE, BLOCK);
    known.insert(Window {
        width: 96,
        ..SIZE.window()
    });
    // On the right nothing is known of depth.
    let still = drawn.still(drawn.depths().within(&known, &known), &[]);
    let places = Places::of(&still, &drawn.all(decor, 1.0));
    let mut sums = Sums::default();
    for (k, instance) in decor.iter().enumerate() {
        let thing = drawn.changed(instance, share);
        let is_shaded = |to: &Changed| shades(still.lights, &thing, to);
        if thing.whole == Bounds::Unbounded || still.shadows && moving.iter().any(is_shaded) {
            continue;
        }
        let mut scene = drawn.case.scene.clone();
        scene.instances.remove(k);
        let colour = Output::ColourOverBackground;
        let without = picture(&drawn.case, &drawn.table, scene, SIZE, colour);
        let mut all = BlockSet::none(SIZE, side(&drawn.case));
        all.insert(SIZE.window());
        let mut spared = BlockSet::none(SIZE, side(&drawn.case));
        let idle = |w: &Window| !matters(&still, &thing, &places, with_ring(*w, SIZE));
        spared.insert_all(all.windows().filter(idle));
        let changed = differing(&drawn.full, &without, SIZE);
        let missed = changed.iter().filter(|(x, y)| spared.has_pixel(*x, *y));
        sums.missed += missed.count();
        sums.differing += changed.len();
        sums.left_alone += spared.numbers().len();
    }
    sums
}

#[test]
fn nothing_changes_where_nothing_reaches() {
    let sums = sums(1.0, 60, reached);
    println!("{sums:?}");
    assert!(sums.differing > 30_000 && sums.left_alone > 100, "{sums:?}");
    assert_eq!(sums.missed, 0);
}

#[test]
fn what_does_not_matter_in_a_block_can_be_left_out_of_it() {
    let sums = sums(1.0, 60, left_out);
    println!("{sums:?}");
    assert!(
        sums.differing > 30_000 && sums.left_alone > 1_000,
        "{sums:?}"
    );
    assert_eq!(sums.missed, 0);
}

/// The tests above would notice.
#[test]
fn what_is_too_small_is_found_out() {
    for check in [reached, left_out] {
        let sums = sums(0.6, 20, check);
        assert!(sums.missed > 0, "{sums:?}");
    }
}
