//! Bloom, the acuity of eyes, and the end of the picture for hosts that draw into an HDR picture of their own.
//!
//! - **What it is**: the picture is halved again and again and added up from the smallest, each level with the share of light
//!   that an eye spreads that far (the CIE's glare function, [`himmel_core::vision::glare_per_sr`]). No threshold: every pixel
//!   gives the same share, all of it arrives somewhere.
//! - **What it costs**: two passes a level; a third more memory than two pictures of 16 bytes a pixel at half size.
//! - **What it leaves out**: the coloured rays and hairs of the glare (ciliary corona, lenticular halo); a picture's distortion
//!   away from its middle; light from outside the picture.

use himmel_core::vision::encircled_glare;

use super::params::{Bloom, OutputParams};
use crate::error::GpuError;
use crate::gpu::Gpu;
use crate::layout::gpu_struct;
use crate::pass::{Bound, Slot, bind, full_screen, layout, module};
use crate::phenomena::cleared;
use crate::still::{Picture, Pixels};
use crate::target::{Output, Target};
use crate::view::View;

/// Most levels of the chain; 16 halve a side of 65,536.
const MOST_LEVELS: usize = 16;
/// Floats, so that the Sun's disc does not overflow.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;
/// Median radius of the light of a level that was halved k times and added up again: 0.81 · 2^k pixels. (Variance along a
/// side: 0.75 by halving, 0.67 by doubling, four times as much for each further level; of a Gaussian the median radius is
/// 1.18 σ.)
const RADIUS_PX: f64 = 0.81;

gpu_struct! {
    /// What the passes are told; the fields are explained in `bloom.wgsl`.
    pub struct BloomUniform {
        /// Shares of the levels.
        pub shares: [[f32; 4]; 4],
        /// Share of the picture itself.
        pub own_share: f32,
        /// Levels in use.
        pub levels: u32,
        /// Angle of a pixel.
        pub degrees_per_pixel: f32,
        /// What luminance was multiplied by.
        pub exposure: f32,
        /// 1: blurred as eyes are.
        pub acuity: u32,
        /// Index of the tone mapper.
        pub tonemap: u32,
        /// 1: display-encoded target, 2: sRGB target.
        pub encoding: u32,
        /// Steps of the target that dithering hides; 0: off.
        pub dither_levels: f32,
        /// Largest finite value of the target.
        pub largest: f32,
        /// 1: linear on the way out.
        pub linear_out: u32,
        /// Fills up.
        pub padding_0: f32,
        /// Fills up.
        pub padding_1: f32,
    }
}

/// What a picture is, for [`BloomPass::record`].
#[derive(Clone, Copy, Debug)]
pub struct BloomFrame<'a> {
    /// Bloom, acuity, tone mapper, dithering.
    pub output: &'a OutputParams,
    /// Angle of a pixel in the middle of the picture: [`View::degrees_per_pixel`](crate::View::degrees_per_pixel).
    pub degrees_per_pixel: f64,
    /// What luminance in cd m⁻² was multiplied by to give the picture; with `exposure_texel` a factor on that, such as
    /// 2^compensation.
    pub exposure: f64,
    /// A texel whose red is that factor: [`SkyRenderer::exposure_view`](crate::SkyRenderer::exposure_view).
    pub exposure_texel: Option<&'a wgpu::TextureView>,
}

/// The passes. Make one for each view that is shown at the same time: it keeps the view's levels and settings.
pub struct BloomPass {
    device: wgpu::Device,
    queue: wgpu::Queue,
    target: Target,
    layout: wgpu::BindGroupLayout,
    /// Down, up, finish.
    pipelines: [wgpu::RenderPipeline; 3],
    uniform: wgpu::Buffer,
    one: wgpu::TextureView,
    chain: Option<Chain>,
}

/// Textures for a size.
struct Chain {
    size: (u32, u32),
    /// Halved, and added up: one view for each level.
    halved: Vec<wgpu::TextureView>,
    added: Vec<wgpu::TextureView>,
    whole: wgpu::TextureView,
    bytes: u64,
}

impl BloomPass {
    /// Compiles the passes. `target`: format of the picture that comes out, and whether it is linear
    /// ([`Output::Radiance`]) or tone mapped ([`Output::Display`]); one sample a pixel.
    pub fn new(device: &wgpu::Device, queue: &wgpu::Queue, target: &Target) -> Result<Self, GpuError> {
        target.check(device)?;
        if target.samples != 1 || target.depth.is_some() {
            return Err(GpuError::Target("bloom writes a picture of one sample a pixel, without depth".into()));
        }
        let module = module(device, "output/bloom.wgsl")?;
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("bloom"),
            size: size_of::<BloomUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let slots = [
            (0, Slot::Uniform(uniform.size(), false)),
            (1, Slot::Table),
            (2, Slot::Table),
            (3, Slot::Table),
            (4, Slot::Table),
        ];
        let layout = layout(device, "bloom", wgpu::ShaderStages::FRAGMENT, &slots);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("bloom"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline =
            |fragment, format| full_screen(device, &module, &pipeline_layout, ["bloom_vertex", fragment], &[], format);
        let one = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("one"),
            size: wgpu::Extent3d { width: 1, height: 1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: FORMAT,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let texel = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: None, rows_per_image: None };
        queue.write_texture(one.as_image_copy(), bytemuck::cast_slice(&[1f32; 4]), texel, one.size());
        Ok(Self {
            device: device.clone(),
            queue: queue.clone(),
            target: *target,
            pipelines: [
                pipeline("bloom_down", FORMAT),
                pipeline("bloom_up", FORMAT),
                pipeline("bloom_finish", target.colour),
            ],
            layout,
            uniform,
            one: one.create_view(&Default::default()),
            chain: None,
        })
    }

    /// Memory of its levels in bytes.
    pub fn bytes(&self) -> u64 {
        self.chain.as_ref().map_or(0, |chain| chain.bytes)
    }

    /// Records the passes: from `colour_in` (linear Rec. 709 times exposure, a float format) to `colour_out`, which has the
    /// pass's format and the same size. NaN counts as black, infinity as 1e30. Textures are made when the size changes, nothing
    /// else is allocated but bind groups.
    pub fn record(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        colour_in: &wgpu::TextureView,
        colour_out: &wgpu::TextureView,
        frame: &BloomFrame<'_>,
    ) -> Result<(), GpuError> {
        let (from, to) = (colour_in.texture(), colour_out.texture());
        if from.size() != to.size() || from.sample_count() != 1 || to.sample_count() != 1 {
            return Err(GpuError::View(format!(
                "bloom wants two pictures of one size and one sample a pixel, got {}x{} and {}x{}",
                from.width(),
                from.height(),
                to.width(),
                to.height()
            )));
        }
        if to.format() != self.target.colour {
            return Err(GpuError::Target(format!(
                "bloom was made for {:?}, not {:?}",
                self.target.colour,
                to.format()
            )));
        }
        if !(frame.degrees_per_pixel > 0.0 && frame.degrees_per_pixel.is_finite() && frame.exposure.is_finite()) {
            return Err(GpuError::View("bloom needs a pixel's angle above 0 and a finite exposure".into()));
        }
        let size = (from.width(), from.height());
        if self.chain.as_ref().is_none_or(|chain| chain.size != size) {
            self.chain = Some(Chain::new(&self.device, size));
        }
        let Some(chain) = &self.chain else { return Err(GpuError::Device("no levels".into())) };
        let levels = if frame.output.has_post() { chain.halved.len() } else { 0 };
        let uniform = self.uniform_of(frame, levels);
        self.queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&uniform));
        let exposure = frame.exposure_texel.unwrap_or(&self.one);
        let pass = |encoder: &mut wgpu::CommandEncoder, which: usize, level: usize, pictures: [&_; 3], to: &_| {
            let [source, smaller, whole] = pictures;
            let bound = [
                (0, Bound::Buffer(&self.uniform)),
                (1, Bound::View(source)),
                (2, Bound::View(smaller)),
                (3, Bound::View(whole)),
                (4, Bound::View(exposure)),
            ];
            let group = bind(&self.device, "bloom", &self.layout, &bound);
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some(["bloom, down", "bloom, up", "bloom, finish"][which]),
                color_attachments: &[Some(cleared(to))],
                ..Default::default()
            });
            pass.set_pipeline(&self.pipelines[which]);
            pass.set_bind_group(0, &group, &[]);
            pass.draw(0..3, level as u32..level as u32 + 1);
        };
        let one = &self.one;
        for level in 0..levels {
            let source = if level == 0 { colour_in } else { &chain.halved[level - 1] };
            pass(encoder, 0, level, [source, one, one], &chain.halved[level]);
        }
        for level in (0..levels).rev() {
            let smaller = chain.added.get(level + 1).unwrap_or(one);
            pass(encoder, 1, level, [&chain.halved[level], smaller, one], &chain.added[level]);
        }
        let (sum, whole) = if levels > 0 { (&chain.added[0], &chain.whole) } else { (one, one) };
        pass(encoder, 2, 0, [colour_in, sum, whole], colour_out);
        Ok(())
    }

    fn uniform_of(&self, frame: &BloomFrame<'_>, levels: usize) -> BloomUniform {
        let output = frame.output;
        let (own, of_levels) = shares(output.bloom, output.bloom_amount, frame.degrees_per_pixel, levels);
        let mut shares = [[0.0; 4]; 4];
        for (level, share) in of_levels.into_iter().enumerate() {
            shares[level / 4][level % 4] = share as f32;
        }
        BloomUniform {
            shares,
            own_share: own as f32,
            levels: levels as u32,
            degrees_per_pixel: frame.degrees_per_pixel as f32,
            exposure: frame.exposure as f32,
            acuity: u32::from(output.acuity),
            tonemap: output.tonemap as u32,
            encoding: if self.target.colour.is_srgb() { 2 } else { 1 },
            dither_levels: if output.dither { self.target.levels() } else { 0.0 },
            largest: self.target.largest().unwrap_or(1.0),
            linear_out: u32::from(self.target.output == Output::Radiance),
            ..BloomUniform::default()
        }
    }
}

impl Chain {
    fn new(device: &wgpu::Device, size: (u32, u32)) -> Self {
        let half = |side: u32| side.div_ceil(2).max(1);
        let first = (half(size.0), half(size.1));
        // To the level whose larger side is 1.
        let levels = ((32 - first.0.max(first.1).leading_zeros()) as usize).clamp(1, MOST_LEVELS);
        let view = |texture: &wgpu::Texture, first, count| {
            texture.create_view(&wgpu::TextureViewDescriptor {
                base_mip_level: first,
                mip_level_count: Some(count),
                ..Default::default()
            })
        };
        let texture = |label| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: first.0, height: first.1, depth_or_array_layers: 1 },
                mip_level_count: levels as u32,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: FORMAT,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
                view_formats: &[],
            })
        };
        let (halved, added) = (texture("bloom, halved"), texture("bloom, added"));
        let views = |texture: &wgpu::Texture| (0..levels as u32).map(|level| view(texture, level, 1)).collect();
        Self {
            size,
            halved: views(&halved),
            added: views(&added),
            whole: view(&halved, 0, levels as u32),
            bytes: 2 * u64::from(first.0) * u64::from(first.1) * 16 * 4 / 3,
        }
    }
}

/// The share of the picture itself and of each level, by the angle that light is spread to; they sum to 1.
///
/// Laws tested: sum 1; none without bloom; positive; smaller pixels spread more.
pub fn shares(bloom: Bloom, amount: f64, degrees_per_pixel: f64, levels: usize) -> (f64, Vec<f64>) {
    let age_years = match bloom {
        Bloom::None => return (1.0, vec![0.0; levels]),
        Bloom::Eye => 25.0,
        Bloom::OldEye => 80.0,
    };
    // Brown eyes.
    let within =
        |level: usize| encircled_glare(RADIUS_PX * 2f64.powf(level as f64 + 0.5) * degrees_per_pixel, age_years, 0.5);
    let edges: Vec<f64> = (0..levels).map(within).chain([1.0]).collect();
    let spread: f64 = 1.0 - edges[0];
    let factor = if spread > 0.0 { amount.min(1.0 / spread) } else { 0.0 };
    (1.0 - factor * spread, edges.windows(2).map(|edge| factor * (edge[1] - edge[0])).collect())
}

/// A picture with bloom and acuity, linear or finished.
///
/// `picture`: linear, times its exposure.  `view`: what it shows.
pub fn finish(
    gpu: &Gpu,
    picture: &Picture,
    output: &OutputParams,
    view: &View,
    kind: Output,
) -> Result<Picture, GpuError> {
    let Pixels::Radiance(rgb) = &picture.pixels else {
        return Err(GpuError::Target("bloom needs a linear picture".into()));
    };
    let (width, height) = (picture.width, picture.height);
    let largest = gpu.device.limits().max_texture_dimension_2d;
    if width == 0 || height == 0 || width > largest || height > largest {
        return Err(GpuError::Size {
            width,
            height,
            max: largest,
            max_pixels: u64::from(largest) * u64::from(largest),
        });
    }
    let texture = |format, usage| {
        gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("bloom, picture"),
            size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage,
            view_formats: &[],
        })
    };
    let (format, texel) = match kind {
        Output::Radiance => (FORMAT, 16),
        Output::Display => (wgpu::TextureFormat::Rgba8Unorm, 4),
    };
    let from = texture(FORMAT, wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST);
    let to = texture(format, wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC);
    let rgba: Vec<[f32; 4]> = rgb.chunks_exact(3).map(|c| [c[0], c[1], c[2], 1.0]).collect();
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 16), rows_per_image: None };
    gpu.queue.write_texture(from.as_image_copy(), bytemuck::cast_slice(&rgba), layout, from.size());
    let row_bytes = (width * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
    let buffer = gpu.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("bloom, picture"),
        size: u64::from(row_bytes) * u64::from(height),
        usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut bloom = BloomPass::new(&gpu.device, &gpu.queue, &Target::new(format, kind))?;
    let mut encoder = gpu.device.create_command_encoder(&Default::default());
    let frame = BloomFrame {
        output,
        degrees_per_pixel: view.degrees_per_pixel(height),
        exposure: picture.exposure,
        exposure_texel: None,
    };
    let views = [&from, &to].map(|texture| texture.create_view(&Default::default()));
    bloom.record(&mut encoder, &views[0], &views[1], &frame)?;
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(row_bytes), rows_per_image: None };
    let destination = wgpu::TexelCopyBufferInfo { buffer: &buffer, layout };
    encoder.copy_texture_to_buffer(to.as_image_copy(), destination, to.size());
    gpu.queue.submit([encoder.finish()]);
    let bytes = gpu.read_buffer(&buffer, buffer.size())?;
    let rows = bytes.chunks_exact(row_bytes as usize).map(|row| &row[..(width * texel) as usize]);
    let pixels = match kind {
        Output::Display => {
            Pixels::Display(rows.flat_map(|row| row.chunks_exact(4).flat_map(|p| [p[0], p[1], p[2]])).collect())
        }
        Output::Radiance => Pixels::Radiance(
            rows.flat_map(|row| row.chunks_exact(16).flat_map(|p| bytemuck::pod_read_unaligned::<[f32; 3]>(&p[..12])))
                .collect(),
        ),
    };
    Ok(Picture { pixels, ..picture.clone() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_keep_all_light() {
        let mut last = 1.0;
        for degrees in [1.0, 0.1, 0.02, 0.002] {
            for bloom in [Bloom::Eye, Bloom::OldEye] {
                for amount in [0.0, 1.0, 10.0] {
                    let (own, levels) = shares(bloom, amount, degrees, 10);
                    let sum = own + levels.iter().sum::<f64>();
                    assert!((sum - 1.0).abs() < 1e-12 && own >= 0.0 && levels.iter().all(|share| *share >= 0.0));
                }
            }
            let own = shares(Bloom::Eye, 1.0, degrees, 10).0;
            println!("{degrees}° a pixel: {:.3} stays", own);
            assert!(own < last);
            last = own;
        }
        assert_eq!(shares(Bloom::None, 1.0, 0.1, 3), (1.0, vec![0.0; 3]));
    }
}
