//! Probes: a GLSL snippet, its inputs, and what it must return, run on a device over a million inputs.
//!
//! A snippet reads `x0, x1, ...` (floats) or `n0, n1, ...` (the same words) and assigns `y0, y1, ...` or, in a row of bits,
//! `m0, m1, ...`. A real row passes where |gpu - f64| <= K eps (|y| + sum |x_i dy/dx_i|): eps = 2^-24, the conditioning by central
//! differences in f64, because an input rounded to f32 already moves the result by that much. The f64 side says what NaN and
//! infinity are expected; unexpected ones fail, and so do results outside the row's range.

use rayon::prelude::*;

use super::inputs::Inputs;
use super::report::{Gate, GateRow, is_wanted};
use crate::gpu::{Device, TableBody};
use crate::shader::cache::Cache;
use crate::shader::compile::{Source, compile};

/// Half an ulp of 1 in f32.
pub const EPS: f64 = 5.960_464_477_539_063e-8;
/// Results below the normal numbers may be flushed to 0 (SPIR-V requires no denormals).
const FLUSHED: f64 = 1.175_494_350_822_287_5e-38;

type Generate = Box<dyn Fn(&mut Inputs) -> Vec<u32> + Send + Sync>;
type Bits = Box<dyn Fn(&[u32], &mut [u32]) + Send + Sync>;
type Real = Box<dyn Fn(&[f64], &mut [f64]) + Send + Sync>;
/// Largest error over the allowed one.
type Judge = Box<dyn Fn(&[f32], &[f32]) -> f64 + Send + Sync>;

enum Check {
    Bits(Bits),
    Real(Real),
    Judge(Judge),
}

/// One row of gate 2 or 3.
pub struct Probe {
    pub name: String,
    pub glsl: String,
    /// Embedded shader files, in order.
    pub files: Vec<&'static str>,
    pub defines: Vec<(&'static str, u32)>,
    /// Generated text before the files: constants, loaders.
    pub prelude: String,
    /// Constant tables that the files read.
    pub tables: Vec<(&'static str, Vec<[u32; 4]>)>,
    /// Further functions that the row covers, besides those its snippet calls.
    pub covers: &'static [&'static str],
    inputs: usize,
    outputs: usize,
    generate: Generate,
    check: Check,
    k: f64,
    absolute: f64,
    is_vector: bool,
    range: (f64, f64),
    why: String,
}

/// The shared files of shaders/core.
pub const CORE: [&str; 6] =
    ["core/math.glsl", "core/exp.glsl", "core/trig.glsl", "core/random.glsl", "core/frame.glsl", "core/warp.glsl"];

impl Probe {
    fn new(name: &str, glsl: &str, inputs: usize, outputs: usize, generate: Generate, check: Check) -> Self {
        Self {
            name: name.into(),
            glsl: glsl.into(),
            files: CORE.to_vec(),
            // What reads a path's state or the scene's tables is left out.
            defines: vec![("IN_KERNEL", 0)],
            prelude: String::new(),
            tables: Vec::new(),
            covers: &[],
            inputs,
            outputs,
            generate,
            check,
            k: 4.0,
            absolute: 0.0,
            is_vector: false,
            range: (f64::NEG_INFINITY, f64::INFINITY),
            why: String::new(),
        }
    }

    /// M floats against f64.
    pub fn real<const N: usize, const M: usize>(
        name: &str,
        glsl: &str,
        generate: impl Fn(&mut Inputs) -> [f32; N] + Send + Sync + 'static,
        reference: impl Fn([f64; N]) -> [f64; M] + Send + Sync + 'static,
    ) -> Self {
        let check = Check::Real(Box::new(move |x, y| {
            y.copy_from_slice(&reference(std::array::from_fn(|i| x[i])));
        }));
        Self::new(name, glsl, N, M, Box::new(move |r| generate(r).map(f32::to_bits).to_vec()), check)
    }

    /// M words, equal bit for bit.
    pub fn bits<const N: usize, const M: usize>(
        name: &str,
        glsl: &str,
        generate: impl Fn(&mut Inputs) -> [u32; N] + Send + Sync + 'static,
        reference: impl Fn([u32; N]) -> [u32; M] + Send + Sync + 'static,
    ) -> Self {
        let check = Check::Bits(Box::new(move |x, y| {
            y.copy_from_slice(&reference(std::array::from_fn(|i| x[i])));
        }));
        Self::new(name, glsl, N, M, Box::new(move |r| generate(r).to_vec()), check)
    }

    /// Judged as a whole: the error over what is allowed. For properties, and where a step may fall to either side.
    pub fn judged<const N: usize>(
        name: &str,
        glsl: &str,
        outputs: usize,
        generate: impl Fn(&mut Inputs) -> [f32; N] + Send + Sync + 'static,
        judge: impl Fn(&[f32], &[f32]) -> f64 + Send + Sync + 'static,
    ) -> Self {
        let generate = Box::new(move |r: &mut Inputs| generate(r).map(f32::to_bits).to_vec());
        Self::new(name, glsl, N, outputs, generate, Check::Judge(Box::new(judge)))
    }

    /// K of the bound; 4 unless said.
    pub fn k(mut self, k: f64) -> Self {
        self.k = k;
        self
    }

    /// Absolute error allowed besides, and why.
    pub fn absolute(mut self, error: f64, why: &str) -> Self {
        self.absolute = error;
        self.because(why)
    }

    /// The outputs are one vector: each component is held to the largest one's scale.
    pub fn vector(mut self) -> Self {
        self.is_vector = true;
        self
    }

    /// Results outside [low, high] fail.
    pub fn within(mut self, low: f64, high: f64) -> Self {
        self.range = (low, high);
        self
    }

    pub fn because(mut self, why: &str) -> Self {
        self.why = why.into();
        self
    }

    pub fn covers(mut self, functions: &'static [&'static str]) -> Self {
        self.covers = functions;
        self
    }

    /// Files after the core.
    pub fn files(mut self, files: &[&'static str]) -> Self {
        self.files.extend_from_slice(files);
        self
    }

    pub fn define(mut self, name: &'static str, value: u32) -> Self {
        self.defines.push((name, value));
        self
    }

    pub fn prelude(mut self, text: &str) -> Self {
        self.prelude += text;
        self
    }

    pub fn table(mut self, name: &'static str, rows: Vec<[u32; 4]>) -> Self {
        self.tables.push((name, rows));
        self
    }

    pub fn gate(&self) -> Gate {
        if matches!(self.check, Check::Bits(_)) { Gate::Integers } else { Gate::Functions }
    }

    fn bound(&self) -> String {
        let why = if self.why.is_empty() { String::new() } else { format!("; {}", self.why) };
        match self.check {
            Check::Bits(_) => "equal bit for bit".into(),
            Check::Judge(_) => self.why.clone(),
            Check::Real(_) => {
                let scale = if self.is_vector { "max|y|" } else { "|y|" };
                let absolute = if self.absolute > 0.0 { format!(" + {:.1e}", self.absolute) } else { String::new() };
                let range = match self.range {
                    (low, high) if low.is_finite() || high.is_finite() => format!(", in [{low}, {high}]"),
                    _ => String::new(),
                };
                format!("{} eps ({scale} + sum|x dy/dx|){absolute}{range}{why}", self.k)
            }
        }
    }

    fn source(&self) -> Result<(Source, Vec<TableBody>), String> {
        let (n, m) = (self.inputs, self.outputs);
        let mut head = String::from(
            "layout(local_size_x = 64) in;\n\
             layout(set = 0, binding = 0, std430) readonly buffer IN_block { uint words[]; } IN;\n\
             layout(set = 0, binding = 1, std430) buffer OUT_block { uint words[]; } OUT;\n",
        );
        let bodies = vec![TableBody::Storage; self.tables.len()];
        for ((binding, (name, _)), body) in (2..).zip(&self.tables).zip(&bodies) {
            head += &body.glsl(name, binding);
        }
        head += &self.prelude;
        let mut main = "void main() {\n    uint index = gl_GlobalInvocationID.x;\n".to_owned();
        let is_bits = matches!(self.check, Check::Bits(_));
        for i in 0..n {
            main +=
                &format!("    uint n{i} = IN.words[index * {n}u + {i}u];\n    float x{i} = uintBitsToFloat(n{i});\n");
        }
        let (kind, letter, zero) = if is_bits { ("uint", "m", "0u") } else { ("float", "y", "0.0") };
        (0..m).for_each(|i| main += &format!("    {kind} {letter}{i} = {zero};\n"));
        main += &format!("    {}\n", self.glsl);
        for i in 0..m {
            let word = if is_bits { format!("m{i}") } else { format!("floatBitsToUint(y{i})") };
            main += &format!("    OUT.words[index * {m}u + {i}u] = {word};\n");
        }
        let mut source = Source::new(&format!("probe {}", self.name)).part("<head>", head);
        for (name, value) in &self.defines {
            source = source.define(name, *value);
        }
        for file in &self.files {
            source = source.file(file).map_err(|e| e.to_string())?;
        }
        Ok((source.part("<probe>", main + "}\n"), bodies))
    }

    /// Results of the device for `count` inputs (a multiple of 64).
    pub fn results(&self, device: &Device, words: &[u32], count: usize) -> Result<Vec<u32>, String> {
        let (source, bodies) = self.source()?;
        let spirv = compile(&source, &Cache::user()).map_err(|e| e.to_string())?;
        let text = |e: crate::gpu::GpuError| e.to_string();
        let pipeline = device.pipeline(&spirv, &[]).map_err(text)?;
        let input = device.buffer("IN", size_of_val(words) as u64).map_err(text)?;
        input.write(0, words).map_err(text)?;
        let output = device.buffer("OUT", (count * self.outputs * 4) as u64).map_err(text)?;
        let mut tables = Vec::new();
        for ((name, rows), body) in self.tables.iter().zip(bodies) {
            tables.push(device.table(name, rows, body).map_err(text)?);
        }
        let mut bindings = vec![input.binding(), output.binding()];
        bindings.extend(tables.iter().map(|t| t.binding()));
        device.dispatch(&pipeline, &bindings, &[], [(count / 64) as u32, 1, 1]).map_err(text)?;
        output.read(0..count * self.outputs).map_err(text)
    }

    /// The device's results for `count` inputs, in input order: for rows that judge all samples together.
    pub fn outputs(&self, device: &Device, count: usize) -> Result<Vec<u32>, String> {
        self.results(device, &self.input_words(count), count)
    }

    fn input_words(&self, count: usize) -> Vec<u32> {
        let n = self.inputs;
        let mut words = vec![0u32; count * n];
        words.par_chunks_mut(n * 4096).enumerate().for_each(|(chunk, part)| {
            for (i, row) in part.chunks_mut(n).enumerate() {
                row.copy_from_slice(&(self.generate)(&mut Inputs::new(&self.name, (chunk * 4096 + i) as u32)));
            }
        });
        words
    }

    /// Runs the row. A kernel that does not compile is a failure with the compiler's words.
    pub fn run(&self, device: &Device, count: usize) -> GateRow {
        let n = self.inputs;
        let words = self.input_words(count);
        let results = match self.results(device, &words, count) {
            Ok(results) => results,
            Err(message) => return GateRow::new(self.gate(), &self.name, false, message, self.bound()),
        };
        let worst = words
            .par_chunks(n)
            .zip(results.par_chunks(self.outputs))
            .enumerate()
            .map(|(i, (x, y))| (self.error(x, y), i))
            .reduce(|| (0.0, 0), |a, b| if b.0 > a.0 || (b.0 == a.0 && b.1 < a.1) { b } else { a });
        let (error, at) = worst;
        let (x, y) = (&words[at * n..][..n], &results[at * self.outputs..][..self.outputs]);
        let used = match self.check {
            Check::Bits(_) => if error > 0.0 { "differs" } else { "equal" }.to_owned(),
            Check::Real(_) if error.is_finite() => format!("{:.2} of {} eps", error * self.k, self.k),
            _ => format!("{error:.3} of the bound"),
        };
        let evidence = format!("{used}, {count} inputs; worst {}", self.describe(x, y));
        GateRow::new(self.gate(), &self.name, error <= 1.0, evidence, self.bound())
    }

    /// Error over bound at one input: passes up to 1. Infinite where a NaN, an infinity or a range is violated.
    fn error(&self, x: &[u32], y: &[u32]) -> f64 {
        match &self.check {
            Check::Bits(reference) => {
                let mut wanted = vec![0; y.len()];
                reference(x, &mut wanted);
                if wanted == y { 0.0 } else { f64::INFINITY }
            }
            Check::Real(reference) => {
                let x: Vec<f64> = x.iter().map(|&b| f64::from(f32::from_bits(b))).collect();
                let mut wanted = vec![0.0; y.len()];
                reference(&x, &mut wanted);
                self.real_error(reference, &x, &wanted, y)
            }
            Check::Judge(judge) => {
                let float = |w: &[u32]| w.iter().map(|&b| f32::from_bits(b)).collect::<Vec<f32>>();
                let error = judge(&float(x), &float(y));
                if error.is_nan() { f64::INFINITY } else { error }
            }
        }
    }

    fn real_error(&self, reference: &Real, x: &[f64], wanted: &[f64], y: &[u32]) -> f64 {
        let largest = wanted.iter().filter(|v| v.is_finite()).fold(0.0f64, |a, v| a.max(v.abs()));
        let mut worst = 0.0f64;
        let mut conditioning: Option<Vec<f64>> = None;
        for (i, (&want, &bits)) in wanted.iter().zip(y).enumerate() {
            let got = f64::from(f32::from_bits(bits));
            // What f32 would make of the exact result: beyond its range that is infinity.
            let overflows = want.abs() > f64::from(f32::MAX) * (1.0 - self.k * EPS);
            if want.is_nan() || got.is_nan() || want.is_infinite() || (got.is_infinite() && !overflows) {
                let is_same = (want.is_nan() && got.is_nan()) || want == got;
                if is_same {
                    continue;
                }
                return f64::INFINITY;
            }
            if got.is_infinite() {
                continue;
            }
            if got < self.range.0 || got > self.range.1 {
                return f64::INFINITY;
            }
            let scale = if self.is_vector { largest } else { want.abs() };
            let floor = (FLUSHED + self.absolute) / EPS;
            // Conditioning is asked for only where the bound without it does not do: of a million inputs the worst then lies just
            // below 1 wherever conditioning matters, which says nothing of how close the function is to failing.
            let mut error = (got - want).abs() / (EPS * (self.k * scale + floor));
            if error > 1.0 {
                let c = conditioning.get_or_insert_with(|| conditioning_of(reference, x, y.len()));
                let moved = if self.is_vector { c.iter().fold(0.0f64, |a, v| a.max(*v)) } else { c[i] };
                error = (got - want).abs() / (EPS * (self.k * (scale + moved) + floor));
            }
            worst = worst.max(error);
        }
        worst
    }

    fn describe(&self, x: &[u32], y: &[u32]) -> String {
        let show = |w: &[u32], is_bits: bool| {
            let one = |&b: &u32| {
                if is_bits { format!("{b:#010x}") } else { format!("{b:#010x} ({:.7e})", f32::from_bits(b)) }
            };
            w.iter().map(one).collect::<Vec<_>>().join(", ")
        };
        let is_bits = matches!(self.check, Check::Bits(_));
        let wanted = match &self.check {
            Check::Bits(reference) => {
                let mut wanted = vec![0; y.len()];
                reference(x, &mut wanted);
                format!(", wanted {}", show(&wanted, true))
            }
            Check::Real(reference) => {
                let mut wanted = vec![0.0; y.len()];
                reference(&x.iter().map(|&b| f64::from(f32::from_bits(b))).collect::<Vec<_>>(), &mut wanted);
                format!(", wanted {}", wanted.iter().map(|w| format!("{w:.9e}")).collect::<Vec<_>>().join(", "))
            }
            Check::Judge(_) => String::new(),
        };
        format!("at {} got {}{wanted}", show(x, is_bits), show(y, is_bits))
    }
}

/// Sum over the inputs of |x_i dy/dx_i| for each output, by central differences of relative step 2^-20.
fn conditioning_of(reference: &Real, x: &[f64], outputs: usize) -> Vec<f64> {
    let step = 2f64.powi(-20);
    let mut sum = vec![0.0; outputs];
    let (mut up, mut down, mut moved) = (vec![0.0; outputs], vec![0.0; outputs], x.to_vec());
    for i in (0..x.len()).filter(|&i| x[i] != 0.0 && x[i].is_finite()) {
        moved[i] = x[i] * (1.0 + step);
        reference(&moved, &mut up);
        moved[i] = x[i] * (1.0 - step);
        reference(&moved, &mut down);
        moved[i] = x[i];
        for (s, (u, d)) in sum.iter_mut().zip(up.iter().zip(&down)) {
            let slope = (u - d).abs() / (2.0 * step);
            *s += if slope.is_finite() { slope } else { 0.0 };
        }
    }
    sum
}

/// Runs the rows that `filter` names, several at a time: compiling one beside checking another.
pub fn run_all(device: &Device, probes: &[Probe], filter: &str, count: usize) -> Vec<GateRow> {
    probes.par_iter().filter(|p| is_wanted(p.gate(), &p.name, filter)).map(|p| p.run(device, count)).collect()
}
