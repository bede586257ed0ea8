//! Ondine: a data-oriented wavefront path tracer for the CPU.
//!
//! Five stages work on queues of rays, eight at a time, and hand each other what lives on:
//!
//! ```text
//! scene ──► generate ──► intersect ──► shade ──► nee ──► accumulate ──► film
//!              ▲             ▲           │        │
//!          (pixel, sample)   └── bounce ─┘        └─ shadow rays: intersect (is anything between?)
//! ```
//!
//! A *wave* is some two thousand paths (a tile of pixels × a block of 16 samples) that one worker carries from `generate`
//! to `accumulate` in queues of its own. The queues fit in that core's L2 cache, and nothing is shared while the wave
//! runs. The loop is [`wavefront::trace`], on one page: iterative, one kernel for each stage, compaction between.
//!
//! ```
//! use ondine::render::{Control, Settings, render};
//! use ondine::scene::builtin;
//! use std::sync::atomic::AtomicBool;
//!
//! let scene = builtin::open("cornell")?; // or the path of a scene file
//! let mut settings = Settings::of(&scene);
//! settings.set_size(64, 48);
//! settings.spp = 4;
//! let control = Control { stop: &AtomicBool::new(false), progress: &|_paths| () };
//! let rendered = render(&scene, &settings, &control)?;
//!
//! let [red, green, blue] = rendered.film.mean(32, 24); // linear radiance, W·sr⁻¹·m⁻²
//! assert!(red > 0.0 && green > 0.0 && blue > 0.0);
//! println!("{:.1} Mrays/s", rendered.stats.millions_per_second(rendered.stats.rays()));
//! # Ok::<(), ondine::error::Error>(())
//! ```
//!
//! # The house
//!
//! An arrow may only point down; stages meet in [`wavefront::queues`] and nowhere else.
//!
//! | floor | rooms |
//! |---|---|
//! | 7 | [`cli`]: arguments become validated settings, and those a command |
//! | 6 | [`batch`]: many images from one file: jobs, what is there of them, and what is rendered; [`mod@bench`]: the benchmark suite; `view`: the live page |
//! | 5 | [`mod@render`]: tiles, or light probes, go to rayon workers, one workspace each; [`stats`]: what it took; [`dump`]: every record of a few paths as files, and a port's held to them; [`merge`]: parts of an image, put together; [`resume`]: what there is of an image already |
//! | 4 | [`wavefront`]: the loop, its five stages, their queues |
//! | 3 | [`scene`]: what a scene file says, and the tables that kernels read; [`compare`]: whether two images are of one scene, up to noise |
//! | 2 | [`shape`]: spheres and quads; [`bvh`]: the tree of triangles; [`material`]: one file for each BSDF; [`film`]: exact pixels, OpenEXR, PNG |
//! | 1 | [`sampling`]: random numbers with names, and the warps they go through; [`texture`]: images on surfaces; [`sh`]: spherical harmonics; [`npy`]: NumPy's files |
//! | 0 | [`lanes`]: eight-lane vectors, colours, records, queues; [`error`]: what can go wrong |
//!
//! # Records, batches, queues
//!
//! A *record* is declared once, with [`record!`], and exists in two shapes: one lane and eight. A [`lanes::Queue`] is a
//! list of eight-lane batches and a length. The batch is the queue's storage and the kernel's argument, so nothing is
//! transposed on the way. A batch that is kept whole is stored as it is; what is kept of others closes up in one last
//! batch, so paths that end leave no empty lanes behind; [`stats`] reports the lane use of each stage. Hits wait in a queue for
//! each material kind: a kernel never branches on it. No kernel allocates or recurses.
//!
//! Masks are `f32x8` with all bits of a lane on or off, and a scalar oracle in `tests/` holds each wide kernel to the
//! textbook. There is one shading path, and it is the wide one.
//!
//! # Meshes
//!
//! [`bvh::Bvh`] is two trees in one: the upper one of instances, the lower ones of meshes; what occurs once lies in the world,
//! and a scene of one mesh has no upper tree. The triangle test is watertight (Woop et al. 2013), the box test conservative.
//! A ray asks the shapes first, then the tree of triangles with that distance as its limit, then a second tree of those that
//! have holes: what most meshes are never pays for a cut-out. Hits on meshes have queues of their own, for they carry two
//! normals and what textures say; a scene without meshes takes no step for them. The geometric normal decides which side a
//! direction is on and where rays start, the shading normal what is reflected. A mesh that emits is one light, whose
//! triangles are chosen by area: so its density is the same all over, and no triangle needs a number but to be chosen by.
//!
//! # Spherical harmonics
//!
//! [`sh::Basis`] evaluates the basis in eight directions, [`sh::Series`] sums it up with coefficients while it does, so that no
//! room for its values is needed, whatever the degree. Images are projected in their own frame, whose pole is +y: there
//! integrals over pixels are products, along a row in closed form; the coefficients are then turned, exactly. Phong lobes have
//! a closed form in which nothing cancels ([`sh::lobe`]).
//!
//! A [sensor](scene::sensor::Sensor) is a camera, or points that look all around. A [probe's](render::probes) waves are those
//! of a render; in place of pixels they add up coefficients, in sixteen independent sets, whose spread is the standard error.
//! An environment of harmonics is drawn from a grid by its magnitude; where it is negative, it stays so, or the path tracer
//! would find another light than the [double sum](render::double_sum), which it is held to.
//!
//! # The same bits
//!
//! An image is a function of scene, settings and seed: not of the number of threads, the size of tiles and waves, or the
//! order in which they finish, whether it was resumed, or into how many shards it was split. Three decisions carry this.
//!
//! - Every random number is a function of (seed, pixel, sample, edge, [dimension](sampling::Dimension)): nothing is drawn
//!   "next", and no worker has a generator.
//! - The light of a path is added up in the order of its edges, the samples of a pixel in blocks of 16, in their order,
//!   in `f64`; and block sums enter wide fixed-point integers ([`film::exact`]), whose addition is associative. What is
//!   not finite or would overflow is counted and kept out. Sums of spherical harmonics have parts that do not depend on the
//!   number of threads, added in their order.
//! - Kernels use only operations that IEEE 754 rounds exactly, and fused multiply-adds are written out. So the bits are
//!   the same on every machine *of one set of target features*: a build without FMA rounds twice where another rounds
//!   once, and is promised nothing.
//!
//! Known to fall short: of a ray that runs in a triangle's own plane, to a ten-millionth of its length, the edge functions are
//! rounding errors. Whether such a triangle is met may then hang on the boxes around it, and these on whether the ray went in
//! a packet or alone, which waves of another size can change.
//!
//! `docs/specification.md` says the operations, one by one; `tools/check_paths.py` renders by it alone, in Python, and gets
//! the same hashes.
//!
//! [`film::Film::image_hash`] names the bits of an image. A change of them is always in `CHANGELOG.md`.
//!
//! # Parts, checkpoints, many images
//!
//! What an image has is a set of [sample blocks](film::Coverage): a shard is some of them, a checkpoint the first so many, a
//! merge adds them up and refuses any that is there twice. Waves are handed out in their order and each that is begun ends, so
//! what is done is always the first so many, and no note has to be kept of which.
//!
//! Workers form a crew: each takes a wave of the oldest image that has one. For a
//! checkpoint an image is held back until its waves under way have ended, and the worker that ended the last writes it, while
//! the others go on with other images. A [batch](render::many()) reads and compiles the next scene while these are traced, and
//! writes finished images meanwhile: so cores are busy to the end, however small the images are. Jobs of one scene share it;
//! scenes that differ in materials alone share [trees](scene::trees).
//!
//! For more than one machine a batch becomes a [folder of command lines](batch::cluster). Each may be run again at any time;
//! who runs them is a scheduler's business.
//!
//! # The live page
//!
//! What a page looks at is a list of changes of the scene and settings, nothing else: so there is always a command line that renders
//! the same, and `view` opens the changed scene the way `render` does. A round of waves is some whole passes over one side, a tenth
//! of a second of them; between rounds the film is one that `render` would have made. A change stops the round after the waves in
//! hand. The first picture after it has as few pixels as can be traced in a fortieth of a second, as fast as the scene was last seen to be.
//! Pictures are half floats, painted when somebody waits for one, less and less often as the image ages; a page gets the next when it has drawn
//! the last. So what readers cost does not grow with how slow they are.
//!
//! # Benchmarks
//!
//! [`mod@bench`] times whole renders of fixed scenes by turns, and gives a rate only to a right image: right by the statistics of
//! [`compare`] against a stored reference, which other random numbers made, and of the same bits in every repeat. What a change
//! costs each kernel is counted in instructions (`tools/count_instructions.py`), which no other program on the machine disturbs;
//! the same counts of operations and bytes, and the machine's peaks as `bench` measures them, make its roofline.
//!
//! # What makes it quick
//!
//! - Six quads that close a box around the rest become a [`shape::Room`]: three slabs, three quotients, no edges to test.
//!   Only where no path leaves it: the camera is inside, and no wall transmits.
//! - A quad with the whole scene on one side ("hull") stands between no two points of it: shadow rays that end in the
//!   scene skip it.
//! - On its last edge a path can but find light: the nearest light is looked for, and then whether anything is between.
//! - Kernels take [`wavefront::queues::GROUP`] batches through each step before the next step: the roots and quotients of
//!   one batch wait while those of the next begin.
//! - Tables of up to 16 rows (materials, lights, surfaces) are kept by column, and read by shuffles: [`lanes::Table`].
//! - Hits are compared as bit patterns: one unsigned minimum for three comparisons of floats ([`shape`]).
//! - Numbers beyond [`sampling::LAST_SOBOL_BOUNCE`] are hashes: no stratum survives that many dimensions.
//! - In a scene of one material kind a vertex goes straight to its queue: with a loop over the kinds it waits in memory. Few
//!   rays find light by themselves, so what that takes stands aside. Intersecting the box takes a tenth less.
//! - Triangles are met by a tree of eight children a node and eight triangles a leaf ([`bvh`]). Rays that keep together go as
//!   packets of 16: a bundle of intervals against eight boxes. The others go as a stream: 32 are under way, and each takes its
//!   step without a branch that could be mispredicted. Either way a triangle test is the same operations, so which way a ray
//!   goes changes no bit.
//! - Rays enter the stream where they part. Neighbours begin in the same corner of the tree: half of all nodes that a bounced
//!   ray meets hold its origin, and those of its seven neighbours. Eight go down to there at once (1.1 times faster); where
//!   any hit will do, they go on while five of them do (1.2 times).
//! - Up to 64 triangles, rays that begin near each other are sorted by greatest axis and octant, and are bundles again: 1.4
//!   times faster for shadow rays in a box. Those that do not try each triangle.
//! - The next place of a ray is asked for a whole round before it is read: 1.15 times faster on a million triangles in pixel
//!   order, 1.35 times in random order.
//! - A box in a tree that is built is one register, its low corner negated: one maximum joins two boxes, and what is parted is
//!   loaded as it was stored; half a store cannot be passed on to a whole load. Two thirds of the time for a million triangles.
//! - Long runs are parted by all threads. Children, and their order for all octants at once, are worked out without an
//!   allocation; nodes are moved once, to their place. Another quarter less. Binned by turns from both halves of a run, neighbours
//!   seldom wait for one another in one bin: a twentieth less.
//! - Sobol's second dimension is Pascal's triangle modulo 2: four butterfly steps instead of a table.
//!
//! # Decided against
//!
//! - Image-wide queues, as on a GPU: they stream through memory what waves keep in the cache. A wavefront like that is
//!   slower on a CPU than a plain loop over paths (pbrt-v4's own: 0.92 of the speed of its scalar integrator).
//! - Trees for small scenes: eight rays that meet one primitive at a time beat any tree up to about 64 primitives.
//! - Another order of Sobol' indices: a random order of each block of 16 in place of Burley's hierarchical shuffle
//!   decorrelates padded pairs (odd × odd interactions have 1.06 times the variance of independent numbers, not 1.6 times),
//!   yet it won at most 1.5 % of relative error on the box and cost the equality with `sobol_burley`, lane by lane.
//! - Packets of 32 rays: no faster than 16 on a million triangles, and slower in a box. Bundles whose slopes are more than
//!   an eighth apart: shadow rays towards a wide lamp trace half as fast as in the stream.
//! - Asking a packet whether any ray is inside a triangle before its hit is taken note of: primary rays are 1.12 times faster
//!   without the question. Gathering a packet's triangles in a list before they are tested: no faster.
//! - Testing the leaves that eight rays meet on their common way at once: 2 %, for shadow rays alone.
//! - Unchecked indexing in the tree, 16 or 64 rays under way in place of 32: no faster, or slower.
//! - Rotating harmonics by recursion from degree to degree (Ivanic & Ruedenberg 1996): off by 10⁻¹⁰ at degree 64 and 2·10⁻⁵
//!   at 128. Wigner's functions, each by itself, stay below 10⁻¹².
//! - Lengths of a stream's lists in an array by kind: each step then waits for the one before; registers are 1.25 times
//!   faster.
//! - Masks kept as data, so that the compiler makes no masked stores: 10 % slower shading.
//! - Rows and columns of camera rays by eight-lane division in place of a counter: no faster.
//! - Closing up what is left of a batch field by field, without a branch on how many lanes there are: no faster.
//! - The inverse of a sphere's cone by the stable `s / (1 + sqrt(1 − s))`: a quotient that waits for a root. A short series
//!   and the plain difference, each where it is exact, take its place.

pub mod batch;
pub mod bench;
pub mod bvh;
pub mod cli;
pub mod compare;
pub mod dump;
pub mod error;
pub mod film;
pub mod lanes;
pub mod material;
pub mod merge;
pub mod npy;
pub mod render;
pub mod resume;
pub mod sampling;
pub mod scene;
pub mod sh;
pub mod shape;
pub mod stats;
pub mod texture;
#[cfg(feature = "view")]
pub mod view;
pub mod wavefront;
