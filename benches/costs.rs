//! What it takes to price a plan: counting the work of periods, and the model of
//! the pool. A planner that tries many periods does both for each.

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use decor::film;
use decor::objects::Cache;
use decor::plan::{Costs, Mode, Wishes, Work, plan};
use decor::segmentation::Measure;
use decor::stage::Stage;
use decor_api::RunContext;

fn stage(work: &Path) -> Stage {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/ladybirds/ladybirds.anim");
    let film = film::read(&path, false).expect("a bundled film");
    let adapter = decor::renderers::find("reference").expect("it is always there");
    let run = RunContext::new(work);
    Stage::set(film, adapter, false, &Cache::disabled(), &run).expect("a bundled film")
}

fn benchmark(criterion: &mut Criterion) {
    let work = tempfile::tempdir().expect("a folder");
    let stage = stage(work.path());
    let wishes = Wishes {
        mode: Mode::Equivalent,
        threshold_px: 1.0,
        measure: Measure::Bound,
        period: Some(5),
        budget: None,
        shadow_way: decor::plan::ShadowWay::Auto,
        frames: (0, 24),
        with_depth: false,
        fallback: false,
    };
    let plan = plan(&stage, wishes, &Costs::default()).expect("a plan");
    let works: Vec<Work> = plan.works(&stage);
    let costs = Costs::default();
    let mut group = criterion.benchmark_group("costs");
    group.throughput(Throughput::Elements(25));
    group.bench_function("work of 25 frames of 100 objects", |b| {
        b.iter(|| black_box(plan.works(&stage)));
    });
    group.bench_function("pool of 25 frames", |b| {
        b.iter(|| black_box(costs.film(&works, 16, 2)));
    });
    let many: Vec<&Work> = works.iter().cycle().take(400).collect();
    group.throughput(Throughput::Elements(2000));
    group.bench_function("pool of 2000 frames", |b| {
        b.iter(|| black_box(costs.film(many.iter().copied(), 16, 2)));
    });
    group.finish();
}

criterion_group!(benches, benchmark);
criterion_main!(benches);
