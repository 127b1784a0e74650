//! Random scenes: whatever they hold, the frames are POV-Ray's.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::dice::Dice;
use crate::random_scene::RandomScene;
use crate::trial::{ALWAYS, both};

/// POV-Ray sleeps most of the time.
const AT_ONCE: u64 = 20;

fn number(variable: &str) -> Option<u64> {
    std::env::var(variable).ok()?.parse().ok()
}

/// A seed that nobody has tried, where none is stated.
fn seed() -> u64 {
    number("DECOR_RANDOM_SEED").unwrap_or_else(|| {
        let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
        now.unwrap().as_millis() as u64 % 1_000_000_000
    })
}

#[test]
fn random_scenes_come_out_as_from_povray_alone() {
    let count = number("DECOR_UNEDITED_SCENES").unwrap_or(6);
    let (seed, first) = (seed(), number("DECOR_UNEDITED_FIRST").unwrap_or(0));
    println!("{count} random scenes from {first} of seed {seed} (DECOR_RANDOM_SEED)");
    let (next, coherent) = (AtomicU64::new(first), AtomicU64::new(0));
    let failures = Mutex::new(Vec::new());
    let work = || {
        loop {
            let k = next.fetch_add(1, Ordering::Relaxed);
            if k >= first + count {
                return;
            }
            let folder = tempfile::tempdir().unwrap();
            let scene = RandomScene::of(&mut Dice::of(seed, k));
            scene.write(folder.path());
            let out = folder.path().join("out");
            let tried = std::panic::catch_unwind(|| {
                both(folder.path(), "s.pov", &scene.switches(), ALWAYS, &out)
            });
            let wrong = match tried {
                Err(_) => Some("it fails".to_owned()),
                Ok(tried) => {
                    let whole = tried.whole();
                    println!("scene {k}: {} dirty {whole}", tried.summary["dirty_blocks"]);
                    coherent.fetch_add(u64::from(whole.is_empty()), Ordering::Relaxed);
                    let differ = format!("{:?} differ", tried.differing);
                    (!tried.differing.is_empty()).then_some(differ)
                }
            };
            if let Some(wrong) = wrong {
                let kept = folder.keep();
                let kept = kept.display();
                let line = format!("scene {k} of seed {seed}, kept in {kept}: {wrong}");
                println!("{line}");
                failures.lock().unwrap().push(line);
            }
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..AT_ONCE.min(count) {
            scope.spawn(work);
        }
    });
    let failures = failures.into_inner().unwrap();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
    let coherent = coherent.into_inner();
    println!("{coherent} of {count} scenes by coherence");
    assert!(count < 6 || coherent > 0, "not one scene by coherence");
}
