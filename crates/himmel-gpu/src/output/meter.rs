//! Automatic exposure: draws a small picture and averages its luminance into one texel, without a read-back.

use glam::DVec3;
use himmel_core::vision::{EIGENGRAU_CD_M2, adaptation_seconds, brightness, mesopic, scotopic_from_rec709};

use super::eye::LUMINANCE_WEIGHTS;
use super::params::{Adaptation, OutputParams};
use crate::error::GpuError;
use crate::layout::gpu_struct;
use crate::pass::{Bound, Slot, bind, full_screen, layout};
use crate::shader;

/// Pixels darker than this share of the mean do not count, and the luminance of nothing at all, cd m⁻²; as in `meter.wgsl`.
const DARK_SHARE: f64 = 1e-3;
const DARKEST: f64 = 1e-5;

/// The exposure value that makes a picture's geometric mean luminance middle grey, 0.18: the f64 twin of `meter.wgsl`,
/// without compensation.
///
/// `luminance_cd_m2`: of every pixel, `None` outside the picture (the corners of a fisheye).
/// Laws tested: an even picture becomes 0.18; twice as bright is one more; black space beside it changes nothing.
pub fn metered_ev100(luminance_cd_m2: impl Iterator<Item = Option<f64>> + Clone) -> f64 {
    ev100_of_middle(log_means(luminance_cd_m2.map(|value| value.map(|value| [value; 2])))[0])
}

/// The factor on luminance that automatic exposure chooses for a picture, adapted to it, without compensation: that of
/// [`metered_ev100`]; for an eye what it sees of the mean, darker where it sees less ([`brightness`]).
///
/// `rgb_cd_m2`: linear Rec. 709 of every pixel, `None` outside the picture.
pub fn metered_factor(output: &OutputParams, rgb_cd_m2: impl Iterator<Item = Option<DVec3>> + Clone) -> f64 {
    let scotopic = scotopic_from_rec709();
    let means = log_means(rgb_cd_m2.map(|rgb| rgb.map(|rgb| [rgb.dot(LUMINANCE_WEIGHTS), rgb.dot(scotopic)])));
    let mut middle = means[0];
    if output.sees_as_eye() {
        let [photopic, scotopic] = means.map(f64::exp2);
        middle = (mesopic(photopic, scotopic + EIGENGRAU_CD_M2).1 / brightness(photopic, scotopic)).log2();
    }
    (-ev100_of_middle(middle)).exp2() / 1.2
}

/// The exposure value that makes a luminance, 2 to the power of `middle`, middle grey.
fn ev100_of_middle(middle: f64) -> f64 {
    (middle - (1.2 * 0.18f64).log2()).clamp(-12.0, 24.0)
}

/// Means of the logarithms (of 2) of photopic and scotopic luminance.
fn log_means(pixels: impl Iterator<Item = Option<[f64; 2]>> + Clone) -> [f64; 2] {
    let (mut sum, mut all) = (0.0, 0.0);
    for value in pixels.clone() {
        sum += value.map_or(0.0, |value| value[0]).max(0.0);
        all += 1.0;
    }
    let dark = (DARK_SHARE * sum / f64::max(all, 1.0)).max(DARKEST);
    let (mut logs, mut count) = ([0.0; 2], 0.0);
    for value in pixels.flatten().filter(|value| value[0] >= dark) {
        for k in 0..2 {
            logs[k] += value[k].max(DARKEST).log2();
        }
        count += 1.0;
    }
    if count > 0.0 { logs.map(|log| log / count) } else { [DARKEST.log2(); 2] }
}

/// The luminance that an eye is adapted to after some time before a scene of another one: twin of `meter.wgsl`.
///
/// The logarithm follows exponentially. Laws tested: at once without a past; two short steps are nearly one long one; never beyond
/// the goal.
pub fn adapted(before_cd_m2: f64, scene_cd_m2: f64, seconds: f64, adaptation: Adaptation) -> f64 {
    if adaptation == Adaptation::Instant || before_cd_m2 <= 0.0 {
        return scene_cd_m2;
    }
    let pigments = adaptation == Adaptation::Pigments;
    let share = (-seconds.max(0.0) / adaptation_seconds(before_cd_m2, scene_cd_m2 > before_cd_m2, pigments)).exp();
    scene_cd_m2 * (before_cd_m2 / scene_cd_m2).powf(share)
}

gpu_struct! {
    /// What the meter is told; the fields are explained in `meter.wgsl`.
    pub struct MeterUniform {
        /// 1: as bright as an eye finds it.
        pub eye: u32,
        /// Since the last frame; negative: at once.
        pub seconds: f32,
        /// 1: darkness waits for photopigments.
        pub pigments: u32,
        /// Fills up.
        pub padding: u32,
    }
}

impl MeterUniform {
    /// For a frame so many seconds after the last; `None`: adapted at once.
    pub(crate) fn new(output: &OutputParams, seconds: Option<f64>) -> Self {
        let follows = seconds.filter(|seconds| seconds.is_finite() && output.adaptation != Adaptation::Instant);
        Self {
            eye: u32::from(output.sees_as_eye()),
            seconds: follows.map_or(-1.0, |seconds| seconds.max(0.0) as f32),
            pigments: u32::from(output.adaptation == Adaptation::Pigments),
            padding: 0,
        }
    }
}

/// Size of the metering picture: 2,304 rays, a 400th of a 1280×720 frame.
pub(crate) const SIZE: (u32, u32) = (64, 36);
/// Floats, so that the Sun's disc does not overflow.
pub(crate) const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba32Float;

/// The pass that averages; one for a renderer.
pub(crate) struct Meter {
    pub picture: wgpu::TextureView,
    pub exposure: wgpu::Texture,
    pub uniform: wgpu::Buffer,
    before: wgpu::Texture,
    exposure_view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    bind_group: wgpu::BindGroup,
}

impl Meter {
    pub(crate) fn new(device: &wgpu::Device) -> Result<Self, GpuError> {
        let texture = |label, (width, height), usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: FORMAT,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING | usage,
                view_formats: &[],
            })
        };
        let picture = texture("metering picture", SIZE, wgpu::TextureUsages::empty()).create_view(&Default::default());
        let exposure = texture("exposure", (1, 1), wgpu::TextureUsages::COPY_SRC);
        // Zeros at first: nothing that it could be adapted to.
        let before = texture("exposure before", (1, 1), wgpu::TextureUsages::COPY_DST);
        let exposure_view = exposure.create_view(&Default::default());
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("meter"),
            source: wgpu::ShaderSource::Wgsl(shader::module("output/meter.wgsl")?.into()),
        });
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("meter"),
            size: size_of::<MeterUniform>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let slots = [(0, Slot::Table), (1, Slot::Uniform(uniform.size(), false)), (2, Slot::Table)];
        let layout = layout(device, "meter", wgpu::ShaderStages::FRAGMENT, &slots);
        let before_view = before.create_view(&Default::default());
        let bound = [(0, Bound::View(&picture)), (1, Bound::Buffer(&uniform)), (2, Bound::View(&before_view))];
        let bind_group = bind(device, "meter", &layout, &bound);
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("meter"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = full_screen(device, &module, &pipeline_layout, ["meter_vertex", "meter_fragment"], &[], FORMAT);
        Ok(Self { picture, exposure, uniform, before, exposure_view, pipeline, bind_group })
    }

    pub(crate) fn exposure_view(&self) -> &wgpu::TextureView {
        &self.exposure_view
    }

    /// Keeps a fixed factor where the metered one would be, so that hosts find either in the same place.
    pub(crate) fn set(&self, encoder: &mut wgpu::CommandEncoder, factor: f64) {
        let ev100 = -(factor * 1.2).log2();
        let texel = wgpu::Color { r: factor, g: ev100, b: 0.18 / factor, a: 1.0 };
        let ops = wgpu::Operations { load: wgpu::LoadOp::Clear(texel), store: wgpu::StoreOp::Store };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("exposure"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                ops,
                ..crate::phenomena::cleared(&self.exposure_view)
            })],
            ..Default::default()
        });
    }

    /// Averages the picture that was drawn into [`Meter::picture`].
    pub(crate) fn reduce(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        timestamps: Option<wgpu::RenderPassTimestampWrites<'_>>,
    ) {
        encoder.copy_texture_to_texture(
            self.exposure.as_image_copy(),
            self.before.as_image_copy(),
            self.exposure.size(),
        );
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("meter"),
            color_attachments: &[Some(crate::phenomena::cleared(&self.exposure_view))],
            timestamp_writes: timestamps,
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.draw(0..3, 0..1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::params::Exposure;

    #[test]
    fn the_mean_becomes_middle_grey() {
        let even = |value: f64| metered_ev100(std::iter::repeat_n(Some(value), 100));
        let factor = Exposure::Ev100(even(4000.0)).factor().unwrap();
        assert!((4000.0 * factor - 0.18).abs() < 1e-12);
        assert!((even(8000.0) - even(4000.0) - 1.0).abs() < 1e-12);
        let pair = [Some(1000.0), Some(4000.0)];
        assert!((metered_ev100(pair.into_iter()) - even(2000.0)).abs() < 1e-12, "the geometric mean");
        let space = [Some(1000.0), Some(4000.0), Some(0.0), Some(1e-2), None];
        assert!((metered_ev100(space.into_iter()) - even(2000.0)).abs() < 1e-12, "space does not count");
        assert_eq!(metered_ev100([None, Some(0.0)].into_iter()), -12.0);
    }

    /// Ten decades: from 1e-4 to 1e6 cd m⁻² a grey picture is drawn as middle grey; by an eye only by day, darker with the light,
    /// and never brighter than less light.
    #[test]
    fn ten_decades() {
        let eye = OutputParams { tonemap: crate::Tonemap::Eye, ..OutputParams::default() };
        let mut last = 0.0;
        for i in 0..=100 {
            let luminance = 1e-4 * 10f64.powf(f64::from(i) / 10.0);
            let pixels = std::iter::repeat_n(Some(DVec3::splat(luminance)), 10);
            let grey = luminance * metered_factor(&OutputParams::default(), pixels.clone());
            assert!((grey - 0.18).abs() < 1e-9, "{luminance}: {grey}");
            // As it is drawn: exposure times what is seen.
            let drawn = crate::output::eye::seen_by_eye(DVec3::splat(luminance), DVec3::ONE).y;
            let seen = drawn * metered_factor(&eye, pixels);
            assert!(seen > last * 0.999 && seen < 0.18 + 1e-6, "{luminance}: {seen}");
            assert!(luminance < 100.0 || seen > 0.179);
            last = seen;
        }
    }

    #[test]
    fn eyes_follow() {
        for how in [Adaptation::Nerves, Adaptation::Pigments] {
            assert_eq!(adapted(0.0, 100.0, 0.016, how), 100.0);
            for (from, to) in [(1e-3, 1e4), (1e4, 1e-3), (10.0, 12.0)] {
                let step = |from, seconds| adapted(from, to, seconds, how);
                let (once, twice) = (step(from, 0.032), step(step(from, 0.016), 0.016));
                assert!((once / twice).ln().abs() < 0.05 * (to / from).ln().abs(), "{how:?} {from}: {once} {twice}");
                assert!(once >= f64::min(from, to) && once <= f64::max(from, to));
                assert!((step(from, 4000.0) / to).ln().abs() < 1e-3 * (to / from).ln().abs());
            }
        }
        // Into the dark: half way (in decades) after five minutes with pigments, at once without.
        assert!(adapted(100.0, 1e-3, 60.0, Adaptation::Pigments) > 0.5);
        assert!(adapted(100.0, 1e-3, 5.0, Adaptation::Nerves) < 1.1e-3);
        assert_eq!(adapted(5.0, 7.0, 0.0, Adaptation::Instant), 7.0);
    }
}
