//! The model of the pool, on work that can be worked out by hand.

use super::pool::worth_calling;
use super::*;

fn picture(pass: Pass, side: u32) -> Picture {
    let pixels = f64::from(side) * f64::from(side);
    Picture {
        pass,
        pixels,
        covered: 0.0,
        window: (side, side),
        masked: false,
        canvas: pixels,
        parsed: Parsed::default(),
    }
}

fn whole(frames: usize, side: u32) -> Work {
    let frame = FrameWork {
        pictures: vec![picture(Pass::Whole, side)],
        ..FrameWork::default()
    };
    Work {
        frames: vec![frame; frames],
        // Two periods at once.
        size_pixels: 1e6,
        ..Work::default()
    }
}

fn layered(frames: usize, side: u32, window: u32) -> Work {
    let frame = FrameWork {
        pictures: vec![
            picture(Pass::Fast, window),
            picture(Pass::FastDepth, window),
        ],
        ..FrameWork::default()
    };
    Work {
        ground: vec![picture(Pass::Decor, side), picture(Pass::DecorDepth, side)],
        frames: vec![frame; frames],
        // Two periods at once.
        size_pixels: 1e6,
        ..Work::default()
    }
}

/// A call sleeps 1 s, a picture 0.5 s; a pixel is a microsecond of colour and
/// half of one of depth. Nothing else costs.
fn costs() -> Costs {
    let pixel = |any_s| PixelCost {
        any_s,
        covered_s: 0.0,
    };
    Costs {
        arrival_s: 0.0,
        call_sleep_s: 1.0,
        call_cpu_s: 0.0,
        picture_sleep_s: 0.5,
        picture_cpu_s: 0.0,
        canvas_pixel_s: 0.0,
        instance_s: 0.0,
        byte_s: 0.0,
        colour: pixel(1e-6),
        depth: pixel(5e-7),
        fast: pixel(1e-6),
        fast_depth: pixel(5e-7),
        own_call_s: 0.0,
        own_pixel_s: 0.0,
        merge_pixel_s: 0.0,
        encode_pixel_s: 0.0,
        write_pixel_s: 0.0,
    }
}

fn near(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-6
}

#[test]
fn small_pictures_wait_for_sleep() {
    // Eight frames, eight calls at once: each sleeps 1.5 s and computes 1 ms on
    // one of two cores; four turns.
    let price = costs().price(&whole(8, 32), 8, 2);
    assert!(near(price.cpu_s, 8.0 * 1024e-6), "{price:?}");
    assert!(near(price.wall_s, 1.5 + 4.0 * 1024e-6), "{price:?}");
    // One at a time: a call with eight pictures.
    let price = costs().price(&whole(8, 32), 1, 2);
    assert!(
        near(price.wall_s, 1.0 + 8.0 * 0.5 + 8.0 * 1024e-6),
        "{price:?}"
    );
}

#[test]
fn large_pictures_wait_for_the_cores() {
    // A second of work each.
    let price = costs().price(&whole(16, 1000), 8, 2);
    assert!(near(price.cpu_s, 16.0), "{price:?}");
    // Calls of two pictures: they sleep 2 s, then compute 2 s each.
    assert!(near(price.wall_s, 2.0 + 16.0 / 2.0), "{price:?}");
}

#[test]
fn frames_wait_for_their_decor() {
    let work = layered(4, 1000, 100);
    let price = costs().price(&work, 16, 2);
    assert!(near(price.cpu_s, 1.5 + 4.0 * 0.015), "{price:?}");
    // All ten calls sleep 1.5 s together; then 1.56 s of work on two cores.
    assert!(near(price.wall_s, 1.5 + 1.56 / 2.0), "{price:?}");
}

#[test]
fn periods_overlap() {
    let work = layered(4, 100, 32);
    let alone = costs().price(&work, 64, 2);
    let next = costs().in_a_row(&work, 64, 2);
    // Two at a time: each adds half of what it takes.
    assert!(next.wall_s < 0.6 * alone.wall_s, "{next:?} after {alone:?}");
    assert!(near(next.cpu_s, alone.cpu_s));
    let film = costs().film([&work, &work, &work], 64, 2);
    let sum: Price = film.iter().copied().sum();
    assert!(sum.wall_s < 2.1 * alone.wall_s && sum.wall_s > 1.9 * alone.wall_s);
}

#[test]
fn more_of_anything_never_costs_less_work() {
    let base = costs().price(&layered(10, 500, 100), 8, 2);
    for dearer in [
        layered(11, 500, 100),
        layered(10, 510, 100),
        layered(10, 500, 110),
    ] {
        let price = costs().price(&dearer, 8, 2);
        assert!(price.cpu_s > base.cpu_s && price.wall_s > base.wall_s - 1e-9);
    }
    let fewer_cores = costs().price(&layered(10, 500, 100), 8, 1);
    assert!(fewer_cores.wall_s >= base.wall_s && near(fewer_cores.cpu_s, base.cpu_s));
}

#[test]
fn windows_of_a_call_are_as_large_as_its_largest() {
    let mut work = whole(2, 64);
    work.frames[1].pictures[0].window = (40, 64);
    work.frames[1].pictures[0].pixels = 40.0 * 64.0;
    let together = costs().price(&work, 1, 1);
    assert!(
        near(together.cpu_s, 2.0 * 64.0 * 64.0 * 1e-6),
        "{together:?}"
    );
    let apart = costs().price(&work, 2, 1);
    assert!(near(apart.cpu_s, 104.0 * 64.0 * 1e-6), "{apart:?}");
}

#[test]
fn the_stock_renderer_sleeps_between_its_pictures() {
    let price = costs().stock(&whole(10, 1000), 2);
    assert!(near(price.cpu_s, 10.0));
    assert!(near(price.wall_s, 1.0 + 10.0 * 0.5 + 10.0 / 2.0));
}

#[test]
fn no_work_costs_nothing() {
    assert_eq!(costs().film([], 4, 2), []);
    let empty = costs().price(&Work::default(), 4, 2);
    assert_eq!(empty, Price::default());
}

#[test]
fn chunks_give_every_job_a_part() {
    let lengths = |frames, heaviest_px, parts| chunk_lengths(frames, heaviest_px, parts, None);
    assert_eq!(lengths(25, 1e6, 8), [4, 4, 4, 4, 4, 4, 1]);
    assert_eq!(lengths(25, 1e5, 16)[0], 2);
    assert_eq!(lengths(1000, 1e5, 2)[0], 50);
    assert_eq!(lengths(1000, 1e6, 2)[0], 12);
    assert_eq!(lengths(3, 1e9, 16), [1, 1, 1]);
    assert!(lengths(0, 1e6, 8).is_empty());
}

#[test]
fn a_call_is_begun_where_its_frames_pay_for_its_start() {
    let small = 192.0 * 144.0;
    assert_eq!(
        worth_calling(4, small),
        1,
        "a second start would cost a tenth"
    );
    assert_eq!(worth_calling(12, small), 5);
    assert_eq!(worth_calling(100, small), 44);
    assert_eq!(worth_calling(25, 1024.0 * 1024.0), 25);
    assert_eq!(worth_calling(0, small), 1);
    let lengths = |frames| chunk_lengths(frames, small, 16, Some(small));
    assert_eq!(lengths(4), [4]);
    assert_eq!(lengths(12), [3, 3, 3, 3]);
    assert_eq!(lengths(100)[0], 7, "no more than run at once");
}

#[test]
fn chunks_of_dear_frames_shrink_towards_the_end() {
    let lengths = chunk_lengths(100, 1e6, 8, Some(1e6));
    assert_eq!(lengths.iter().sum::<usize>(), 100);
    assert_eq!((lengths[0], lengths.last()), (9, Some(&1)), "{lengths:?}");
    assert!(lengths.windows(2).all(|pair| pair[0] >= pair[1]));
    assert_eq!(
        chunk_lengths(8, 1e6, 1, Some(1e6)),
        [8],
        "nobody else could wait"
    );
}
