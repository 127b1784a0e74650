//! The pool of calls, in the small: what runs when, by the rules of
//! [`render`](crate::render).
//!
//! Workers take the chunks of the open periods in order, or open the next
//! period and render its ground; a chunk is one call for each pass and size of
//! window, all at once, then decor's own work. A call sleeps, then computes; the
//! cores are shared evenly by the threads that compute.

use std::collections::{BTreeMap, VecDeque};

use super::{Costs, FrameWork, Pass, Picture, Price, Work, memory};
use crate::shares::share_of;
use crate::stage::Stage;

/// Pixels of layers that one chunk holds at once, at most.
const CHUNK_PIXELS: f64 = (12 << 20) as f64;

/// Frames in one call, at most.
const CHUNK_FRAMES: usize = 50;

/// Periods whose décors are in memory at once, for pictures of so many pixels:
/// the next one is rendered while the last frames of the one before are; more
/// where pictures are small, for a renderer that mostly sleeps.
pub fn periods_at_once(pixels: f64, jobs: usize) -> usize {
    const OPEN_PIXELS: f64 = (1 << 20) as f64;
    ((OPEN_PIXELS / pixels.max(1.0)) as usize).clamp(2, jobs.max(2))
}

/// Calls at once, where nobody says otherwise: fewer where pictures are large, for each
/// keeps a core busy, fewer still where a pixel takes many rays, and as many scenes as
/// fit into memory.
pub fn jobs(stage: &Stage) -> usize {
    let jobs = stage.adapter.abilities().jobs;
    let state = stage.film.frame(*stage.film.frames().start());
    let is_plain = stage.antialias().is_none() && !stage.has_shadows(&state);
    // On two cores, 100 large frames by 10 and by 14 calls: a plain film took 5.5 and
    // 3.9 s, one with shadows 7.7 s both times, and 318 and 399 MiB.
    let eighths = match (is_large(stage.size().pixels() as f64), is_plain) {
        (false, _) => 8,
        (true, true) => 7,
        (true, false) => 5,
    };
    memory::that_fit(stage, (eighths * jobs).div_ceil(8))
}

/// Does a call over pictures of so many pixels compute for most of its time? Over
/// smaller ones it sleeps.
fn is_large(pixels: f64) -> bool {
    const LARGE_PIXELS: f64 = (1 << 19) as f64;
    pixels > LARGE_PIXELS
}

/// Frames in the chunks of a period of `frames`, of which the heaviest holds so many
/// pixels of layers. `parts`: chunks that are of use, the calls at once, or the cores
/// where nothing is called: those who wait for a décor only keep other décors waiting.
/// `whole`: the pixels of a frame, where frames are rendered whole.
///
/// Chunks are alike, and as a rule all run at once: a call sleeps before it computes.
/// Where frames are whole and large, that is little, and each chunk is a share of what
/// is left, so that no core waits for the last one. Where they are whole and few and
/// small, there are fewer chunks than could run at once.
pub fn chunk_lengths(
    frames: usize,
    heaviest_px: f64,
    parts: usize,
    whole: Option<f64>,
) -> Vec<usize> {
    /// Of large whole frames these are worth a call.
    const SHORT: usize = 2;
    let parts = match whole {
        Some(pixels) => parts.min(worth_calling(frames, pixels)),
        None => parts,
    };
    let parts = parts.max(1);
    let longest = (CHUNK_PIXELS / heaviest_px.max(1.0)) as usize;
    let longest = longest.clamp(1, CHUNK_FRAMES);
    let alike = frames.div_ceil(parts).clamp(1, longest);
    let shrinks = whole.is_some_and(is_large) && parts > 1;
    let mut left = frames;
    let mut lengths = Vec::new();
    while left > 0 {
        let share = share_of(left, parts).max(SHORT);
        let length = if shrinks { share.min(alike) } else { alike };
        lengths.push(length.min(left));
        left -= length.min(left);
    }
    lengths
}

/// Calls that so many whole frames of so many pixels are worth: starting them costs
/// no more CPU time than one call with all threads over all frames has to give.
pub(super) fn worth_calling(frames: usize, pixels: f64) -> usize {
    /// CPU time of a start.
    const START_S: f64 = 0.013;
    /// What a picture costs less where one thread renders it.
    const THREADS_S: f64 = 0.004;
    /// More than stock's CPU time by this share is too much.
    const MORE: f64 = 0.05;
    let costs = Costs::default();
    let frame_s = costs.picture_cpu_s + costs.colour.of(pixels, pixels / 2.0);
    let frames_a_call = START_S / (THREADS_S + MORE * frame_s);
    ((frames as f64 / frames_a_call.max(1.0)) as usize).max(1)
}

/// Something that takes time: it sleeps, then computes.
#[derive(Clone, Copy, Debug)]
struct Load {
    sleep_s: f64,
    cpu_s: f64,
    threads: f64,
}

/// A chunk or a ground: calls side by side, then decor's own work.
struct Task {
    period: usize,
    is_ground: bool,
    calls: Vec<Load>,
    own_s: f64,
}

/// The wall time that each period adds, and its CPU time.
pub fn run<'w>(
    costs: &Costs,
    works: impl IntoIterator<Item = &'w Work>,
    jobs: usize,
    cores: usize,
) -> Vec<Price> {
    let (jobs, cores) = (jobs.max(1), cores.max(1));
    let mut pixels = 0.0_f64;
    let plans: Vec<Vec<Task>> = works
        .into_iter()
        .enumerate()
        .map(|(period, work)| {
            pixels = pixels.max(work.size_pixels);
            tasks(costs, period, work, jobs, cores)
        })
        .collect();
    let cpu: Vec<f64> = plans
        .iter()
        .map(|tasks| {
            let task = |t: &Task| t.own_s + t.calls.iter().map(|c| c.cpu_s).sum::<f64>();
            tasks.iter().map(task).sum()
        })
        .collect();
    let at_once = periods_at_once(pixels, jobs);
    let ends = Pool::new(plans, jobs, cores, at_once).ends();
    let mut before = 0.0_f64;
    ends.into_iter()
        .zip(cpu)
        .map(|(end, cpu_s)| {
            let wall_s = (end - before).max(0.0);
            before = before.max(end);
            Price { wall_s, cpu_s }
        })
        .collect()
}

/// How long the calls of a period hold their places in the pool, added up.
pub fn slot_seconds(costs: &Costs, work: &Work, jobs: usize, cores: usize) -> f64 {
    let tasks = tasks(costs, 0, work, jobs.max(1), cores.max(1));
    let calls = tasks.iter().flat_map(|task| &task.calls);
    calls.map(|call| call.sleep_s + call.cpu_s).sum()
}

/// The tasks of a period: its ground first, where it has one.
fn tasks(costs: &Costs, period: usize, work: &Work, jobs: usize, cores: usize) -> Vec<Task> {
    let ground = work.ground.iter().map(|picture| {
        let mut load = call(costs, std::slice::from_ref(picture));
        load.threads = cores as f64;
        load
    });
    let mut tasks = vec![Task {
        period,
        is_ground: true,
        calls: ground.collect(),
        own_s: costs.encode_pixel_s * work.ground_encoded,
    }];
    let heaviest = work.frames.iter().map(held).fold(1.0, f64::max);
    let calls = work.frames.iter().any(|frame| !frame.pictures.is_empty());
    let parts = if calls { jobs } else { cores };
    let mut left = work.frames.as_slice();
    let whole = work.ground.is_empty().then_some(work.size_pixels);
    for length in chunk_lengths(left.len(), heaviest, parts, whole) {
        let frames;
        (frames, left) = left.split_at(length);
        let mut groups: BTreeMap<(Pass, u32, u32), Vec<Picture>> = BTreeMap::new();
        for picture in frames.iter().flat_map(|frame| &frame.pictures) {
            let (width, height) = if picture.masked {
                (0, 0)
            } else {
                let (width, height) = picture.window;
                (width.next_power_of_two(), height.next_power_of_two())
            };
            let group = groups.entry((picture.pass, width, height));
            group.or_default().push(*picture);
        }
        tasks.push(Task {
            period,
            is_ground: false,
            calls: groups.values().map(|group| call(costs, group)).collect(),
            own_s: frames.iter().map(|frame| own(costs, frame)).sum(),
        });
    }
    tasks
}

/// Pixels of layers that a frame holds.
fn held(frame: &FrameWork) -> f64 {
    let pictures = frame.pictures.iter();
    pictures
        .map(|picture| f64::from(picture.window.0) * f64::from(picture.window.1))
        .sum()
}

/// decor's own work for a frame.
fn own(costs: &Costs, frame: &FrameWork) -> f64 {
    costs.merge_pixel_s * frame.merged
        + costs.encode_pixel_s * frame.encoded
        + costs.write_pixel_s * frame.written
}

/// A call over some pictures, by one thread. Windows are rendered as large as
/// the largest of them.
fn call(costs: &Costs, pictures: &[Picture]) -> Load {
    let area = |width: u32, height: u32| f64::from(width) * f64::from(height);
    let width = pictures.iter().map(|p| p.window.0).max().unwrap_or(0);
    let height = pictures.iter().map(|p| p.window.1).max().unwrap_or(0);
    let canvas = pictures.iter().map(|p| p.canvas).fold(0.0, f64::max);
    let mut cpu_s = costs.call_cpu_s + costs.own_call_s;
    for picture in pictures {
        let pixel = costs.pixel(picture.pass);
        let rendered = if picture.masked {
            picture.pixels
        } else {
            area(width, height)
        };
        cpu_s += costs.read(&picture.parsed)
            + costs.canvas_pixel_s * canvas
            + costs.own_pixel_s * rendered
            + pixel.of(rendered, picture.covered);
    }
    Load {
        sleep_s: costs.call_sleep_s + costs.picture_sleep_s * pictures.len() as f64,
        cpu_s,
        threads: 1.0,
    }
}

/// Something that is under way: a call of a task, or decor's own work for it.
struct Activity {
    task: usize,
    is_call: bool,
    load: Load,
}

/// A task under way.
struct Running {
    task: Task,
    calls_left: usize,
}

struct Pool {
    /// Per period: the tasks that were not begun, the ground first.
    waiting: VecDeque<Vec<Task>>,
    chunks: VecDeque<Task>,
    /// Tasks whose calls are done and whose ground is not.
    held_up: Vec<usize>,
    running: BTreeMap<usize, Running>,
    next_task: usize,
    calls: VecDeque<(usize, Load)>,
    activities: Vec<Activity>,
    workers: usize,
    slots: usize,
    cores: f64,
    now: f64,
    open: usize,
    at_once: usize,
    grounds: Vec<bool>,
    chunks_left: Vec<usize>,
    ends: Vec<f64>,
}

impl Pool {
    fn new(plans: Vec<Vec<Task>>, jobs: usize, cores: usize, at_once: usize) -> Self {
        let periods = plans.len();
        Self {
            chunks_left: plans.iter().map(|tasks| tasks.len() - 1).collect(),
            waiting: plans.into(),
            chunks: VecDeque::new(),
            held_up: Vec::new(),
            running: BTreeMap::new(),
            next_task: 0,
            calls: VecDeque::new(),
            activities: Vec::new(),
            workers: jobs,
            slots: jobs,
            cores: cores as f64,
            now: 0.0,
            open: 0,
            at_once,
            grounds: vec![false; periods],
            ends: vec![0.0; periods],
        }
    }

    /// When each period has its last frame.
    fn ends(mut self) -> Vec<f64> {
        loop {
            self.begin();
            if self.activities.is_empty() {
                return self.ends;
            }
            self.advance();
        }
    }

    /// Gives work to idle workers and free slots.
    fn begin(&mut self) {
        while self.workers > 0 {
            let task = if let Some(chunk) = self.chunks.pop_front() {
                chunk
            } else if self.open < self.at_once
                && let Some(tasks) = self.waiting.pop_front()
            {
                self.open += 1;
                let mut tasks = tasks.into_iter();
                let Some(ground) = tasks.next() else { continue };
                self.chunks.extend(tasks);
                ground
            } else {
                break;
            };
            self.workers -= 1;
            let number = self.next_task;
            self.next_task += 1;
            let calls_left = task.calls.len();
            self.calls
                .extend(task.calls.iter().map(|&call| (number, call)));
            self.running.insert(number, Running { task, calls_left });
            if calls_left == 0 {
                self.called(number);
            }
        }
        while self.slots > 0
            && let Some((task, load)) = self.calls.pop_front()
        {
            self.slots -= 1;
            self.activities.push(Activity {
                task,
                is_call: true,
                load,
            });
        }
    }

    /// Lets time pass until something ends or wakes.
    fn advance(&mut self) {
        let computing = |load: &Load| load.sleep_s <= 0.0;
        let threads: f64 = self
            .activities
            .iter()
            .filter(|a| computing(&a.load))
            .map(|a| a.load.threads)
            .sum();
        let share = (self.cores / threads.max(1.0)).min(1.0);
        let left = |load: &Load| {
            if computing(load) {
                load.cpu_s / (load.threads * share)
            } else {
                load.sleep_s
            }
        };
        let step = self.activities.iter().map(|a| left(&a.load));
        let step = step.fold(f64::INFINITY, f64::min).max(0.0);
        self.now += step;
        let mut done = Vec::new();
        self.activities.retain_mut(|activity| {
            // What ends in this step ends at once, whatever the rounding.
            let last = left(&activity.load) <= step;
            let load = &mut activity.load;
            if !computing(load) {
                load.sleep_s = if last { 0.0 } else { load.sleep_s - step };
                return true;
            }
            load.cpu_s -= step * load.threads * share;
            if last {
                done.push((activity.task, activity.is_call));
            }
            !last
        });
        for (task, is_call) in done {
            if is_call {
                self.slots += 1;
                if let Some(running) = self.running.get_mut(&task) {
                    running.calls_left -= 1;
                    if running.calls_left == 0 {
                        self.called(task);
                    }
                }
            } else {
                self.finished(task);
            }
        }
    }

    /// All calls of a task are done: decor's own work is next, where the ground
    /// is there.
    fn called(&mut self, number: usize) {
        let Some(Running { task, .. }) = self.running.get(&number) else {
            return;
        };
        if !task.is_ground && !self.grounds[task.period] {
            self.held_up.push(number);
            return;
        }
        self.activities.push(Activity {
            task: number,
            is_call: false,
            load: Load {
                sleep_s: 0.0,
                cpu_s: task.own_s,
                threads: 1.0,
            },
        });
    }

    fn finished(&mut self, number: usize) {
        let Some(Running { task, .. }) = self.running.remove(&number) else {
            return;
        };
        self.workers += 1;
        let period = task.period;
        if task.is_ground {
            self.grounds[period] = true;
            for number in std::mem::take(&mut self.held_up) {
                self.called(number);
            }
        } else {
            self.chunks_left[period] -= 1;
        }
        if self.chunks_left[period] == 0 {
            self.open -= 1;
            self.ends[period] = self.now;
        }
    }
}
