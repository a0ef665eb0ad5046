//! Runs functions of `shaders/lib` on a device and compares them with their f64 twins.
//!
//! In: a [`Twin`]: which library files, how to call them, where the inputs come from, what is exact.
//! Out: a [`Report`] of the errors, or one sentence on what differs.
//!
//! The inputs are drawn as f32, so that the exact function is asked the very same question. A result
//! is right when it is within the twin's tolerance of the exact value, or when it lies within what
//! the exact function itself makes of moving each input by a few roundings of f32: no f32 function
//! can be better than that where it is steep or jumps. How many results need the second way is
//! counted and limited.

use ocularium::appearance::images::{Level, MapView, map_image};
use rand::SeedableRng;
use rand_pcg::Pcg64;
use std::future::Future;
use std::path::PathBuf;
use std::pin::pin;
use std::sync::OnceLock;
use std::task::{Context, Poll, Waker};
use wgpu::util::{DeviceExt, TextureDataOrder};

/// Samples for each function.
pub const SAMPLES: usize = 12_000;
/// Roundings of f32 by which an input is moved to find how steep the exact function is.
const ROUNDINGS: f64 = 8.0;
/// No input is taken to be known better than this part of the size of an eye (10 mm) in f32.
const SMALLEST_MOVE: f64 = 1e-7;

/// A device that runs compute shaders.
pub struct Gpu {
    device: wgpu::Device,
    queue: wgpu::Queue,
    /// The adapter's name, for reports.
    pub name: String,
}

impl Gpu {
    /// The one device of the test run: a software adapter where there is one, so that results do not
    /// depend on the machine, otherwise any.
    pub fn shared() -> &'static Self {
        static GPU: OnceLock<Gpu> = OnceLock::new();
        GPU.get_or_init(|| {
            Self::open().unwrap_or_else(|why| {
                panic!(
                    "these tests need a graphics adapter with compute shaders and found none ({why}): \
                     install a software one, for example Debian's mesa-vulkan-drivers"
                )
            })
        })
    }

    fn open() -> Result<Self, String> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
        let request = |software| {
            block_on(instance.request_adapter(&wgpu::RequestAdapterOptions {
                force_fallback_adapter: software,
                ..Default::default()
            }))
        };
        let adapter = request(true)
            .or_else(|_| request(false))
            .map_err(|error| error.to_string())?;
        let (device, queue) = block_on(adapter.request_device(&wgpu::DeviceDescriptor::default()))
            .map_err(|error| error.to_string())?;
        Ok(Self {
            device,
            queue,
            name: adapter.get_info().name,
        })
    }

    /// Runs `call` for each group of `inputs` numbers and returns `outputs` numbers each. `call` is
    /// WGSL statements that read `x[0]`, `x[1]` … and assign `y[0]`, `y[1]` …
    pub fn evaluate(
        &self,
        library: &[&str],
        call: &str,
        data: &[f32],
        inputs: usize,
        outputs: usize,
    ) -> Vec<f32> {
        self.evaluate_with(library, &[], call, data, inputs, outputs)
    }

    /// The same for a call that also reads these textures, every one of them.
    pub fn evaluate_with(
        &self,
        library: &[&str],
        maps: &[Map],
        call: &str,
        data: &[f32],
        inputs: usize,
        outputs: usize,
    ) -> Vec<f32> {
        let count = data.len() / inputs;
        let source = kernel(library, maps, call, inputs, outputs);
        let module = self
            .device
            .create_shader_module(wgpu::ShaderModuleDescriptor {
                label: Some("twin"),
                source: wgpu::ShaderSource::Wgsl(source.into()),
            });
        let pipeline = self
            .device
            .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
                label: Some("twin"),
                layout: None,
                module: &module,
                entry_point: Some("twin_main"),
                compilation_options: Default::default(),
                cache: None,
            });
        let buffer = |size: usize, usage| {
            self.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some("twin"),
                size: size as u64,
                usage,
                mapped_at_creation: false,
            })
        };
        let bytes = count * outputs * 4;
        let source_buffer = buffer(
            data.len() * 4,
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST,
        );
        let result_buffer = buffer(
            bytes,
            wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
        );
        let read_buffer = buffer(
            bytes,
            wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        );
        self.queue
            .write_buffer(&source_buffer, 0, bytemuck::cast_slice(data));
        let textures: Vec<_> = maps.iter().map(|map| self.texture(map)).collect();
        let mut entries = vec![
            source_buffer.as_entire_binding(),
            result_buffer.as_entire_binding(),
        ];
        for (view, sampler) in &textures {
            entries.push(wgpu::BindingResource::TextureView(view));
            entries.push(wgpu::BindingResource::Sampler(sampler));
        }
        let entries: Vec<_> = (0..)
            .zip(entries)
            .map(|(binding, resource)| wgpu::BindGroupEntry { binding, resource })
            .collect();
        let bind_group = self.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("twin"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        let mut encoder = self.device.create_command_encoder(&Default::default());
        {
            let mut pass = encoder.begin_compute_pass(&Default::default());
            pass.set_pipeline(&pipeline);
            pass.set_bind_group(0, &bind_group, &[]);
            pass.dispatch_workgroups(count.div_ceil(64) as u32, 1, 1);
        }
        encoder.copy_buffer_to_buffer(&result_buffer, 0, &read_buffer, 0, bytes as u64);
        self.queue.submit([encoder.finish()]);
        read_buffer
            .slice(..)
            .map_async(wgpu::MapMode::Read, |result| {
                result.expect("the results can be read")
            });
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .expect("the device finishes");
        let mapped = read_buffer.slice(..).get_mapped_range();
        bytemuck::cast_slice(&mapped).to_vec()
    }

    /// The app's own texture of this map, with the sampler that goes with it.
    fn texture(&self, map: &Map) -> (wgpu::TextureView, wgpu::Sampler) {
        let image = map_image(&map.levels, map.wrap);
        let data = image.data.as_deref().expect("a map has texels");
        let order = TextureDataOrder::MipMajor;
        let descriptor = &image.texture_descriptor;
        let texture = self
            .device
            .create_texture_with_data(&self.queue, descriptor, order, data);
        let bevy::image::ImageSampler::Descriptor(sampler) = &image.sampler else {
            panic!("a map says how it is sampled")
        };
        (
            texture.create_view(&Default::default()),
            self.device.create_sampler(&sampler.as_wgpu()),
        )
    }
}

/// A texture that a call reads as `name`, with the sampler `name_sampler`.
#[derive(Clone)]
pub struct Map {
    /// Its name in the call.
    pub name: &'static str,
    /// Its levels, the finest first.
    pub levels: Vec<Level>,
    /// Does it repeat in u?
    pub wrap: bool,
}

impl Map {
    /// The same texels for the f64 twin.
    pub fn view(&self) -> MapView {
        MapView::new(&self.levels, self.wrap)
    }
}

/// Waits for a future that needs no executor, as those of wgpu on native platforms.
fn block_on<F: Future>(future: F) -> F::Output {
    let mut future = pin!(future);
    let mut context = Context::from_waker(Waker::noop());
    loop {
        if let Poll::Ready(output) = future.as_mut().poll(&mut context) {
            return output;
        }
        std::thread::yield_now();
    }
}

fn kernel(library: &[&str], maps: &[Map], call: &str, inputs: usize, outputs: usize) -> String {
    let bindings = maps.iter().enumerate().map(|(i, Map { name, .. })| {
        let (texture, sampler) = (2 * i + 2, 2 * i + 3);
        format!(
            "@group(0) @binding({texture}) var {name}: texture_2d<f32>;
@group(0) @binding({sampler}) var {name}_sampler: sampler;
"
        )
    });
    format!(
        "{}
{}
@group(0) @binding(0) var<storage, read> twin_in: array<f32>;
@group(0) @binding(1) var<storage, read_write> twin_out: array<f32>;
@compute @workgroup_size(64)
fn twin_main(@builtin(global_invocation_id) id: vec3<u32>) {{
    if id.x >= arrayLength(&twin_out) / {outputs}u {{ return; }}
    var x: array<f32, {inputs}>;
    var y: array<f32, {outputs}>;
    for (var i = 0u; i < {inputs}u; i++) {{ x[i] = twin_in[id.x * {inputs}u + i]; }}
    {call}
    for (var i = 0u; i < {outputs}u; i++) {{ twin_out[id.x * {outputs}u + i] = y[i]; }}
}}
",
        joined_library(library),
        bindings.collect::<String>()
    )
}

/// Where the library's files lie.
pub fn library_folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("shaders/lib")
}

/// A library file's text.
pub fn library_text(name: &str) -> String {
    let path = library_folder().join(format!("{name}.wgsl"));
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The texts of the files and of all that they need (their first line `// needs: a.wgsl, b.wgsl`),
/// each once.
pub fn joined_library(names: &[&str]) -> String {
    fn add(name: &str, seen: &mut Vec<String>, text: &mut String) {
        if seen.iter().any(|known| known == name) {
            return;
        }
        seen.push(name.to_owned());
        let source = library_text(name);
        let needs = source
            .lines()
            .next()
            .and_then(|line| line.strip_prefix("// needs: "));
        for needed in needs.into_iter().flat_map(|list| list.split(", ")) {
            add(needed.trim().trim_end_matches(".wgsl"), seen, text);
        }
        text.push_str(&source);
    }
    let (mut seen, mut text) = (Vec::new(), String::new());
    for name in names {
        add(name, &mut seen, &mut text);
    }
    text
}

/// One function of the library and what it must equal.
#[derive(Clone, Copy)]
pub struct Twin<'a> {
    /// Its name in reports.
    pub name: &'a str,
    /// The library files that it stands in, without `.wgsl`.
    pub library: &'a [&'a str],
    /// WGSL statements from `x[…]` to `y[…]`.
    pub call: &'a str,
    /// Draws one group of inputs.
    pub draw: &'a dyn Fn(&mut Pcg64) -> Vec<f32>,
    /// The exact results.
    pub exact: &'a dyn Fn(&[f64]) -> Vec<f64>,
    /// Tolerance, independent of the result's size.
    pub absolute: f64,
    /// Tolerance as a part of the result.
    pub relative: f64,
    /// Largest share of results that may need the exact function's own steepness as an excuse.
    pub steep_share: f64,
}

/// What a comparison found.
#[derive(Debug)]
pub struct Report {
    /// Largest |difference| among the results within tolerance.
    pub worst: f64,
    /// Root of the mean squared difference of the same.
    pub rms: f64,
    /// Share of results outside it, but within what the inputs' rounding explains.
    pub steep: f64,
}

impl Twin<'_> {
    /// Draws [`SAMPLES`] inputs, runs both and compares; prints the report.
    pub fn compare(&self) -> Result<Report, String> {
        self.compare_with(&[])
    }

    /// The same for a function that reads these textures.
    pub fn compare_with(&self, maps: &[Map]) -> Result<Report, String> {
        let gpu = Gpu::shared();
        let mut rng = Pcg64::seed_from_u64(0x0c01_a410);
        let data: Vec<Vec<f32>> = (0..SAMPLES).map(|_| (self.draw)(&mut rng)).collect();
        let outputs = (self.exact)(&widen(&data[0])).len();
        let results = gpu.evaluate_with(
            self.library,
            maps,
            self.call,
            &data.concat(),
            data[0].len(),
            outputs,
        );
        let report = self.judge(&data, &results, outputs)?;
        println!(
            "{}: rms {:.1e}, worst {:.1e}, steep {:.2} % ({SAMPLES} inputs on {})",
            self.name,
            report.rms,
            report.worst,
            100.0 * report.steep,
            gpu.name
        );
        Ok(report)
    }

    fn judge(&self, data: &[Vec<f32>], results: &[f32], outputs: usize) -> Result<Report, String> {
        let (mut worst, mut squares, mut within, mut steep): (f64, f64, u32, u32) =
            (0.0, 0.0, 0, 0);
        for (input, got) in data.iter().zip(results.chunks_exact(outputs)) {
            let x = widen(input);
            let exact = (self.exact)(&x);
            let differences: Vec<f64> = exact
                .iter()
                .zip(got)
                .map(|(e, g)| (e - f64::from(*g)).abs())
                .collect();
            let close = |i: usize| differences[i] <= self.absolute + self.relative * exact[i].abs();
            if (0..outputs).all(close) {
                within += 1;
                for d in differences {
                    worst = worst.max(d);
                    squares += d * d / outputs as f64;
                }
                continue;
            }
            let spread = self.spread(&x, &exact);
            let explained = |i: usize| close(i) || differences[i] <= spread[i];
            if !(0..outputs).all(explained) {
                return Err(format!(
                    "{} of {input:?} is {got:?} on the device and {exact:?} exactly; rounding explains {spread:?}",
                    self.name
                ));
            }
            steep += 1;
        }
        let share = f64::from(steep) / data.len() as f64;
        if share > self.steep_share {
            return Err(format!(
                "{}: {:.2} % of the results are out of tolerance",
                self.name,
                100.0 * share
            ));
        }
        Ok(Report {
            worst,
            rms: (squares / f64::from(within.max(1))).sqrt(),
            steep: share,
        })
    }

    /// How far the exact results move when every input is off by a few roundings, summed over the
    /// inputs as their errors may add up.
    fn spread(&self, x: &[f64], exact: &[f64]) -> Vec<f64> {
        let mut spread = vec![self.absolute; exact.len()];
        for i in 0..x.len() {
            let step = ROUNDINGS * (x[i].abs() * f64::from(f32::EPSILON)).max(SMALLEST_MOVE);
            let mut most = vec![0.0_f64; exact.len()];
            for sign in [-1.0, 1.0] {
                let mut moved = x.to_vec();
                moved[i] += sign * step;
                for ((m, value), e) in most.iter_mut().zip((self.exact)(&moved)).zip(exact) {
                    *m = m.max((value - e).abs());
                }
            }
            spread.iter_mut().zip(most).for_each(|(s, m)| *s += m);
        }
        spread
    }
}

fn widen(values: &[f32]) -> Vec<f64> {
    values.iter().copied().map(f64::from).collect()
}
