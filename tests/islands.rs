//! Blocks from the full scene beside a décor that is up to the threshold off:
//! their borders go through no object.

use std::path::Path;
use std::sync::Arc;

use decor::film;
use decor::motion::screen_box;
use decor::objects::Cache;
use decor::plan::{BlockSet, Costs, FramePlan, Mode, ShadowWay, Wishes, plan};
use decor::segmentation::{Class, Measure};
use decor::stage::Stage;
use decor_api::{RunContext, Window};

/// The bundled cloud in large pictures, with an observer who moves slowly, for
/// the in-process renderer.
fn ladybirds(folder: &Path) -> Stage {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/ladybirds");
    let text = std::fs::read_to_string(source.join("ladybirds.anim")).unwrap();
    let text = text
        .replace("*size 320 240", "*size 1024 768")
        .replace("*images 25", "*images 40")
        .replace("*eye 0 0 -40  0 0 4", "*eye 0 0 -40  0 0 0.1")
        .replace("*aim 0 0 60  0 0 4", "*aim 0 0 60  0 0 0.1");
    std::fs::copy(source.join("ladybird.ron"), folder.join("ladybird.ron")).unwrap();
    let path = folder.join("slow.anim");
    std::fs::write(&path, text).unwrap();
    let film = film::read(&path, false).unwrap();
    let adapter = Arc::new(decor_reference::Reference::new());
    let run = RunContext::new(folder);
    Stage::set(film, adapter, false, &Cache::disabled(), &run).unwrap()
}

/// Pixels of a window that lie in blocks, and all of them.
fn inside(blocks: &BlockSet, window: Window) -> (usize, usize) {
    let rows = window.y..window.bottom();
    let pixels = rows.flat_map(|y| (window.x..window.right()).map(move |x| (x, y)));
    let counted = pixels.filter(|&(x, y)| blocks.has_pixel(x, y)).count();
    (counted, window.pixels())
}

#[test]
fn no_object_of_the_decor_lies_across_a_border() {
    let folder = tempfile::tempdir().unwrap();
    let stage = ladybirds(folder.path());
    let wishes = Wishes {
        mode: Mode::Equivalent,
        threshold_px: 1.0,
        measure: Measure::Bound,
        period: Some(20),
        budget: None,
        frames: (0, 39),
        with_depth: false,
        shadow_way: ShadowWay::Auto,
        fallback: false,
    };
    let plan = plan(&stage, wishes, &Costs::default()).unwrap();
    let (mut islands, mut apart, mut whole) = (0, 0, 0);
    for period in &plan.periods {
        let start = stage.film.frame(period.start);
        let until = stage
            .film
            .frame(period.dissolve_until.unwrap_or(period.start));
        for (number, frame) in period.numbers().zip(&period.frames) {
            let FramePlan::Layered { fast, blocks, .. } = frame else {
                continue;
            };
            if blocks.is_empty() {
                continue;
            }
            assert!(fast.is_empty(), "nothing is merged into frame {number}");
            islands += 1;
            let now = stage.film.frame(number);
            for kept in period.objects.iter().filter(|o| o.class == Class::Slow) {
                // Where the renderer shows it, the décor, and what that turns into.
                let seen = [&start, &now, &until].map(|state| {
                    let object = state.objects.iter().find(|o| o.id == kept.object);
                    let object = object.expect("a ladybird stays in the film");
                    let bounds = stage.prototype(object).bounds.posed(&object.pose);
                    screen_box(&bounds, &state.camera, stage.size()).window()
                });
                // Without the pixel that a box is wider than what is seen.
                let all = seen.into_iter().fold(Window::EMPTY, Window::union);
                if all.width < 3 || all.height < 3 {
                    continue;
                }
                let seen = Window {
                    x: all.x + 1,
                    y: all.y + 1,
                    width: all.width - 2,
                    height: all.height - 2,
                };
                let (counted, pixels) = inside(blocks, seen);
                assert!(
                    counted == 0 || counted == pixels,
                    "frame {number}: {counted} of {pixels} pixels of an object"
                );
                if counted == 0 {
                    apart += 1;
                } else {
                    whole += 1;
                }
            }
        }
    }
    println!("{islands} frames with islands; objects beside them {apart}, in them {whole}");
    assert!(islands > 10 && apart > 100 && whole > 10);
}
