use umbrage_rays::Counts;

use super::records::RayRecords;
use super::space::Part;
use crate::{Buffer, Done, Fetch, Geometry, Gpu, GpuError, Groups, Kernel, Recorder};

/// The kernel that leads rays through a structure.
#[derive(Clone, Debug, PartialEq)]
pub struct Walk {
    /// WGSL modules beside this crate's: pairs of a path and a text.
    pub modules: &'static [(&'static str, &'static str)],
    /// Path of the kernel's module.
    pub path: &'static str,
    /// Name of its entry point.
    pub entry: &'static str,
    /// Values of its `override` constants.
    pub constants: Vec<(&'static str, f64)>,
    /// Rays that are traced together, if any are.
    pub packet: Option<u32>,
}

impl Walk {
    /// Through a [`Hierarchy`](super::Hierarchy).
    pub const HIERARCHY: Self =
        Self { modules: &[], path: "rays::hierarchy", entry: "by_hierarchy", constants: Vec::new(), packet: None };
}

/// How rays are traced.
#[derive(Clone, Debug, PartialEq)]
pub struct RayTracerOptions {
    /// The way through the structure.
    pub walk: Walk,
    /// Whether visits are counted, which takes time.
    pub counts: bool,
    /// Whether rays may start at points of triangles.
    pub from_triangles: bool,
}

impl RayTracerOptions {
    /// Through a hierarchy, for rays that don't start at triangles.
    pub const DEFAULT: Self = Self { walk: Walk::HIERARCHY, counts: false, from_triangles: false };

    /// Rays of a packet, or one.
    #[must_use]
    pub fn lanes(&self) -> u32 {
        self.walk.packet.unwrap_or(1)
    }
}

impl Default for RayTracerOptions {
    fn default() -> Self {
        Self::DEFAULT
    }
}

/// The kind of question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Question {
    Nearest,
    Blocked,
    Passed,
}

/// Kernels that find all surfaces that light passes through, compiled at their first use.
#[derive(Debug)]
struct PassedKernels {
    walk: Kernel,
    settle: Kernel,
}

/// Traces rays on the GPU: the stages `line`, `nearest` or `blocked`, and `settle`.
#[derive(Debug)]
pub struct RayTracer {
    options: RayTracerOptions,
    lines: [Kernel; 2],
    walks: [Kernel; 2],
    size_undecided: Kernel,
    settle_undecided: [Kernel; 2],
    settle_nearest: Kernel,
    passed: Option<PassedKernels>,
    line_words: Buffer,
    /// Four words for each ray.
    traced: Buffer,
    undecided: Buffer,
    undecided_sizes: Buffer,
    hits: Buffer,
    /// Needs of each use since [`RayTracer::prepare`].
    needs: Buffer,
    /// The same, for the CPU.
    fetched: Vec<Fetch>,
    asked: Vec<Question>,
    most_uses: u32,
    work: Vec<RayTracerWork>,
}

/// Work of one use of the tracer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RayTracerWork {
    /// Whether it was about shadows.
    pub is_shadow: bool,
    /// Hits that the predicate had to decide.
    pub undecided_hits: u32,
    /// All zeros unless [counted](RayTracerOptions::counts). A packet counts a node once for each of its rays that may
    /// still find a hit in the node's cell, and a restart for one of its rays.
    pub visits: Counts,
    /// Steps (nodes and tests) of all invocations, including the time that they wait for others. Of 32 invocations in
    /// lockstep, each counts as many as the one with the most; in a packet, each counts all of the packet's. Zero
    /// unless counted.
    pub steps: u64,
}

impl RayTracerWork {
    /// The share of its invocations' steps, 0 to 1, in which a ray visits a node or is tested; in the others it waits
    /// (Horn et al. 2007, §5.2.1). `None` if nothing was counted.
    #[must_use]
    pub fn share_in_use(&self) -> Option<f64> {
        let used = self.visits.nodes + self.visits.tests;
        (self.steps > 0).then(|| used as f64 / self.steps as f64)
    }
}

impl RayTracer {
    /// Words, as in `tester.wgsl`.
    const UNDECIDED_HEADER: u64 = 16;
    const UNDECIDED_WORDS: u64 = 8;
    const UNDECIDED_GROUPS: u32 = 1;
    pub(super) const HIT_WORDS: usize = 8;

    /// Compiles the stages.
    #[must_use]
    pub fn new(gpu: &Gpu, options: impl Into<RayTracerOptions>) -> Self {
        let options = options.into();
        let settle = |entry| Kernel::new(gpu, "rays::settle", entry, &[]);
        let from_triangles = [("RAY_FROM_TRIANGLES", f64::from(u8::from(options.from_triangles)))];
        let settle_hits = Kernel::new(gpu, "rays::settle", "settle_hits", &from_triangles);
        Self {
            lines: both(|is_shadow| Kernel::new(gpu, "rays::line", "line", &[is_shadow])),
            walks: walks(gpu, &options),
            options,
            size_undecided: settle("size_undecided"),
            settle_undecided: [settle_hits, settle("settle_blocked")],
            settle_nearest: settle("settle_nearest"),
            passed: None,
            line_words: Buffer::storage(gpu, "lines of rays"),
            traced: Buffer::storage(gpu, "rays' answers"),
            undecided: Buffer::storage(gpu, "rays' undecided hits"),
            undecided_sizes: Buffer::sizes(gpu, "rays' undecided hits' dispatch sizes"),
            hits: Buffer::storage(gpu, "rays' hits"),
            needs: Buffer::storage(gpu, "rays' needs"),
            fetched: Vec::new(),
            asked: Vec::new(),
            most_uses: 0,
            work: Vec::new(),
        }
    }

    /// Sets the walk for the next uses; `from_triangles` stays.
    pub fn set_options(&mut self, gpu: &Gpu, options: impl Into<RayTracerOptions>) {
        let options = RayTracerOptions { from_triangles: self.options.from_triangles, ..options.into() };
        if options != self.options {
            self.walks = walks(gpu, &options);
            self.options = options;
            self.passed = None;
        }
    }

    /// The options.
    #[must_use]
    pub fn options(&self) -> &RayTracerOptions {
        &self.options
    }

    /// Prepares one submission with up to `uses` uses of up to `rays` rays each.
    ///
    /// # Errors
    /// If a stage needs more bytes than one buffer of the device can have.
    pub fn prepare(&mut self, gpu: &Gpu, rays: u32, uses: u32) -> Result<(), GpuError> {
        let rays = u64::from(rays);
        self.asked.clear();
        self.fetched.clear();
        self.most_uses = uses;
        self.line_words.reserve(gpu, 16 * (1 + 4 * rays))?;
        self.traced.reserve(gpu, 16 * rays.max(1))?;
        self.hits.reserve(gpu, 4 * Self::HIT_WORDS as u64 * rays)?;
        self.undecided.reserve(gpu, Self::undecided_bytes(rays + rays / 8 + (1 << 10)))?;
        self.undecided_sizes.reserve(gpu, 4 * Self::UNDECIDED_HEADER)?;
        self.needs.reserve(gpu, 4 * Self::UNDECIDED_HEADER * u64::from(uses))
    }

    fn undecided_bytes(hits: u64) -> u64 {
        4 * (Self::UNDECIDED_HEADER + Self::UNDECIDED_WORDS * hits)
    }

    /// Records a use that finds the nearest hit of each of `rays`; [`RayTracer::hits`] has the answers.
    ///
    /// # Panics
    /// If it is recorded more often than was prepared for.
    pub fn record_nearest(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        structure: &impl AsRef<[Part]>,
        rays: &RayRecords,
    ) {
        self.record(gpu, recorder, geometry, structure.as_ref(), rays, Question::Nearest);
    }

    /// Records a use that finds whether points are shadowed; [`RayTracer::shadows`] has the answers.
    ///
    /// # Panics
    /// If it is recorded more often than was prepared for.
    pub fn record_blocked(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        structure: &impl AsRef<[Part]>,
        questions: &RayRecords,
    ) {
        self.record(gpu, recorder, geometry, structure.as_ref(), questions, Question::Blocked);
    }

    /// Records a use that lists the structure's triangles between points and a light. [`RayTracer::passed`] has the lists;
    /// the second word of a point's entry in [`RayTracer::shadows`] is the index of its list's first hit.
    ///
    /// # Panics
    /// If it is recorded more often than was prepared for.
    pub(crate) fn record_passed(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        structure: &impl AsRef<[Part]>,
        questions: &RayRecords,
    ) {
        let options = &self.options;
        self.passed.get_or_insert_with(|| PassedKernels {
            walk: walk(gpu, options, &[("RAY_IS_SHADOW", 1.0), ("RAY_IS_PASSED", 1.0)]),
            settle: Kernel::new(gpu, "rays::settle", "settle_passed", &[]),
        });
        self.record(gpu, recorder, geometry, structure.as_ref(), questions, Question::Passed);
    }

    fn record(
        &mut self,
        gpu: &Gpu,
        recorder: &mut Recorder<'_>,
        geometry: &Geometry,
        structure: &[Part],
        rays: &RayRecords,
        question: Question,
    ) {
        let use_index = self.asked.len() as u32;
        assert!(use_index < self.most_uses, "{use_index} uses were prepared for");
        self.asked.push(question);
        let ([line, walk, settle], name) = match (question, &self.passed) {
            (Question::Nearest, _) => ([&self.lines[0], &self.walks[0], &self.settle_undecided[0]], "nearest"),
            (Question::Passed, Some(passed)) => ([&self.lines[1], &passed.walk, &passed.settle], "passed"),
            _ => ([&self.lines[1], &self.walks[1], &self.settle_undecided[1]], "blocked"),
        };
        rays.record_sizes(recorder);
        let groups = Groups::Indirect(rays.sizes(), RayRecords::GROUPS);
        let packets = Groups::Indirect(rays.sizes(), RayRecords::PACKETS);
        recorder.clear_words(&self.undecided, Self::UNDECIDED_HEADER);
        // With no rays, no invocation writes the count.
        recorder.clear_words(&self.line_words, 4);
        let walk_groups = if self.options.walk.packet.is_some() { packets } else { groups };
        for Part { space, nodes, ids } in structure {
            let buffers = [space, rays.buffer(), &self.line_words];
            recorder.stage("line", |pass| line.dispatch(gpu, pass, &buffers, groups));
            let (triangles, positions) = (geometry.triangles(), geometry.positions());
            let buffers = [space, nodes, ids, triangles, positions, &self.line_words, &self.traced, &self.undecided];
            recorder.stage(name, |pass| walk.dispatch(gpu, pass, &buffers, walk_groups));
        }
        let (triangles, positions, masks) = (geometry.triangles(), geometry.positions(), geometry.masks().buffer());
        let buffers = [rays.buffer(), triangles, positions, &self.traced, &self.undecided, &self.hits, masks];
        recorder.stage("settle", |pass| self.size_undecided.dispatch(gpu, pass, &buffers, Groups::Flat(1)));
        recorder.copy_words(&self.undecided, &self.undecided_sizes, Self::UNDECIDED_HEADER);
        recorder.stage("settle", |pass| {
            let undecided = Groups::Indirect(&self.undecided_sizes, Self::UNDECIDED_GROUPS);
            settle.dispatch(gpu, pass, &buffers, undecided);
            if question == Question::Nearest {
                self.settle_nearest.dispatch(gpu, pass, &buffers, groups);
            }
        });
        let slot = Self::UNDECIDED_HEADER * u64::from(use_index);
        recorder.copy_range((&self.undecided, 0), (&self.needs, slot), Self::UNDECIDED_HEADER);
        self.fetched.push(recorder.fetch(&self.undecided, Self::UNDECIDED_HEADER));
    }

    /// Reads the needs of all uses, which are done. If they exceed the room there was, makes more and returns `false`:
    /// the submission has to be repeated.
    ///
    /// # Errors
    /// If the device is lost, or a buffer would need more bytes than the device allows.
    pub fn finish(&mut self, gpu: &Gpu, done: &Done) -> Result<bool, GpuError> {
        self.work.clear();
        let mut most = 0;
        for (fetch, question) in self.fetched.iter().zip(&self.asked) {
            let needs: Vec<u32> = done.read(*fetch)?;
            most = most.max(needs[0]);
            let long = |word: usize| u64::from(needs[word]) | u64::from(needs[word + 1]) << 32;
            let count = |index: usize| long(8 + 2 * index);
            self.work.push(RayTracerWork {
                is_shadow: *question != Question::Nearest,
                undecided_hits: needs[0] - needs[4],
                visits: Counts {
                    rays: needs[5].into(),
                    nodes: count(0),
                    leaves: count(1),
                    tests: count(2),
                    restarts: count(3),
                    ..Counts::default()
                },
                steps: long(6),
            });
        }
        let needed = Self::undecided_bytes(most.into());
        let fits = needed <= self.undecided.bytes();
        if !fits {
            self.undecided.reserve(gpu, (needed + needed / 2).min(gpu.max_binding_bytes()).max(needed))?;
        }
        Ok(fits)
    }

    /// Work of the last finished uses, in order. Rays from mirrors come in a different order each time, so packets of
    /// them may take more or fewer steps.
    #[must_use]
    pub fn work(&self) -> &[RayTracerWork] {
        &self.work
    }

    /// First hit of each ray: eight words, the first of them the triangle or `u32::MAX` (`settle.wgsl`).
    #[must_use]
    pub fn hits(&self) -> &Buffer {
        &self.hits
    }

    /// Four words for each shadow question; the first isn't zero if the point is shadowed.
    #[must_use]
    pub fn shadows(&self) -> &Buffer {
        &self.traced
    }

    /// The hits of [`RayTracer::record_passed`]: 16 words, then eight for each (`settle.wgsl`).
    pub(crate) fn passed(&self) -> &Buffer {
        &self.undecided
    }

    /// Needs of each use: its header begins with the number of undecided hits.
    #[doc(hidden)]
    #[must_use]
    pub fn needs(&self) -> &Buffer {
        &self.needs
    }

    /// Number of undecided hits that there is room for.
    #[doc(hidden)]
    #[must_use]
    pub fn room(&self) -> u32 {
        let hits = (self.undecided.bytes() / 4).saturating_sub(Self::UNDECIDED_HEADER) / Self::UNDECIDED_WORDS;
        hits.min(u64::from(u32::MAX)) as u32
    }

    /// Bytes on the GPU for rays: 112 for each, and 32 for each listed hit.
    #[must_use]
    pub fn bytes(&self) -> u64 {
        [&self.line_words, &self.traced, &self.undecided, &self.hits].into_iter().map(Buffer::bytes).sum()
    }
}

/// The kernels for nearest hits and for shadows.
fn walks(gpu: &Gpu, options: &RayTracerOptions) -> [Kernel; 2] {
    both(|is_shadow| walk(gpu, options, &[is_shadow]))
}

/// The kernel for a kind of question, given as constants.
fn walk(gpu: &Gpu, RayTracerOptions { walk, counts, .. }: &RayTracerOptions, asked: &[(&str, f64)]) -> Kernel {
    let counts = ("RAY_COUNTS", f64::from(u8::from(*counts)));
    let constants = [walk.constants.as_slice(), &[counts], asked].concat();
    Kernel::of_modules(gpu, walk.modules, walk.path, walk.entry, &constants)
}

/// Kernels for nearest hits and for shadows, made by `kernel` from the constant that tells them apart.
fn both(kernel: impl Fn((&'static str, f64)) -> Kernel) -> [Kernel; 2] {
    [0.0, 1.0].map(|is_shadow| kernel(("RAY_IS_SHADOW", is_shadow)))
}
