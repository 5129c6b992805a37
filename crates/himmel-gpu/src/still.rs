//! Pictures of any size without a window: drawn in tiles, read back, joined.

use himmel_air::Atmosphere;

use crate::error::GpuError;
use crate::gpu::Gpu;
use crate::phenomena::air::build::Pace;
use crate::renderer::{FrameState, SkyRenderer};
use crate::target::{Output, Target};
use crate::timing::{PassTimes, Stamps};
use crate::view::View;

/// Largest side of a picture.
pub const MAX_SIDE: u32 = 65_536;
/// Most pixels of a picture: 1.6 GB of floats.
pub const MAX_PIXELS: u64 = 1 << 27;
/// Side of a tile: 4 million pixels keep a software rasteriser busy for a fraction of a second.
const TILE: u32 = 2048;

/// Rows of RGB, top row first.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// Linear Rec. 709, cd m⁻² times exposure.
    Radiance(Vec<f32>),
    /// Finished 8-bit sRGB.
    Display(Vec<u8>),
}

/// A finished picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Its pixels.
    pub pixels: Pixels,
    /// Factor by which luminance was multiplied.
    pub exposure: f64,
    /// The exposure value that this factor corresponds to, compensation included.
    pub ev100: f64,
    /// Times of the passes of the last tile, where the adapter measures them.
    pub times: PassTimes,
}

/// Renders pictures. Keep it to render several: pipelines and textures are made once.
pub struct Still {
    gpu: Gpu,
    renderer: SkyRenderer,
    tile: Option<Tile>,
    stamps: Option<Stamps>,
}

/// A tile's texture and the buffer it is read through.
struct Tile {
    size: (u32, u32),
    texture: wgpu::Texture,
    row_bytes: u32,
    buffer: wgpu::Buffer,
    exposure: wgpu::Buffer,
}

impl Still {
    /// Compiles pipelines and uploads tables.
    pub fn new(gpu: &Gpu, output: Output, atmosphere: &Atmosphere) -> Result<Self, GpuError> {
        let colour = match output {
            Output::Radiance => wgpu::TextureFormat::Rgba32Float,
            Output::Display => wgpu::TextureFormat::Rgba8Unorm,
        };
        let target = Target::new(colour, output);
        let mut renderer = SkyRenderer::new(&gpu.device, &gpu.queue, &target, atmosphere)?;
        // A frame's worth at a time, so that a rebuild can be shown and cancelled.
        renderer.set_pace(Pace::Samples(1e7));
        renderer.set_night_grid(false);
        Ok(Self { gpu: gpu.clone(), renderer, tile: None, stamps: Stamps::new(gpu) })
    }

    /// The renderer, to change its atmosphere.
    pub fn renderer(&mut self) -> &mut SkyRenderer {
        &mut self.renderer
    }

    /// Fills the air's tables to the last order. `progress` is told the share done and answers whether to go on.
    pub fn build(&mut self, progress: &mut dyn FnMut(f64) -> bool) -> Result<(), GpuError> {
        while let Some(state) = self.renderer.rebuilding() {
            let mut encoder =
                self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("air tables") });
            self.renderer.build(&mut encoder);
            self.gpu.queue.submit([encoder.finish()]);
            self.gpu.wait()?;
            if !progress(f64::from(state.progress)) {
                return Err(GpuError::Cancelled);
            }
        }
        Ok(())
    }

    /// Renders a picture of the view's part, once the air's tables are full. `progress` is told the share done after each tile and answers whether to go on.
    pub fn render(
        &mut self,
        frame: &FrameState,
        view: &View,
        width: u32,
        height: u32,
        progress: &mut dyn FnMut(f64) -> bool,
    ) -> Result<Picture, GpuError> {
        let pixel_count = u64::from(width) * u64::from(height);
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE || pixel_count > MAX_PIXELS {
            return Err(GpuError::Size { width, height, max: MAX_SIDE, max_pixels: MAX_PIXELS });
        }
        let display = self.renderer.target().output == Output::Display;
        let count = pixel_count as usize * 3;
        let no_memory = |_| GpuError::Device(format!("not enough memory for {width}x{height} pixels"));
        let mut pixels = if display {
            let mut bytes = Vec::new();
            bytes.try_reserve_exact(count).map_err(no_memory)?;
            bytes.resize(count, 0u8);
            Pixels::Display(bytes)
        } else {
            let mut floats = Vec::new();
            floats.try_reserve_exact(count).map_err(no_memory)?;
            floats.resize(count, 0f32);
            Pixels::Radiance(floats)
        };
        self.build(&mut |_| progress(0.0))?;
        let limit = self.gpu.device.limits().max_texture_dimension_2d.min(TILE);
        let tile_size = (width.min(limit), height.min(limit));
        if self.tile.as_ref().is_none_or(|tile| tile.size != tile_size) {
            self.tile = Some(Tile::new(&self.gpu, tile_size, display));
        }
        let (columns, rows) = (width.div_ceil(tile_size.0), height.div_ceil(tile_size.1));
        let mut reading = [0.0f32; 4];
        let mut times = PassTimes::default();
        for index in 0..columns * rows {
            let (x, y) = (index % columns * tile_size.0, index / columns * tile_size.1);
            // Tiles at the right and bottom edge are drawn whole and cut; ndc points up, rows go down.
            let (w, h) = (f64::from(width), f64::from(height));
            let (tile_w, tile_h) = (f64::from(tile_size.0), f64::from(tile_size.1));
            let [left, bottom, part_w, part_h] = view.part;
            let part = [
                left + part_w * f64::from(x) / w,
                bottom + part_h * (1.0 - (f64::from(y) + tile_h) / h),
                part_w * tile_w / w,
                part_h * tile_h / h,
            ];
            let first_pixel = [view.first_pixel[0].saturating_add(x), view.first_pixel[1].saturating_add(y)];
            let rows_px = (f64::from(height) / view.part[3]).round() as u32;
            let view = View { part, first_pixel, rows_px, ..*view };
            (reading, times) = self.draw_tile(frame, &view)?;
            self.read_tile(&mut pixels, (width, height), (x, y))?;
            if !progress(f64::from(index + 1) / f64::from(columns * rows)) {
                return Err(GpuError::Cancelled);
            }
        }
        let compensation = frame.output.compensation_ev.exp2();
        let chosen = frame.output.exposure_for(self.renderer.target().output);
        let exposure = chosen.factor().unwrap_or(f64::from(reading[0])) * compensation;
        let ev100 = -(exposure * 1.2).log2();
        Ok(Picture { width, height, pixels, exposure, ev100, times })
    }

    fn draw_tile(&mut self, frame: &FrameState, view: &View) -> Result<([f32; 4], PassTimes), GpuError> {
        let Some(tile) = &self.tile else { return Err(GpuError::Device("no tile".into())) };
        let mut encoder =
            self.gpu.device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("still") });
        self.renderer.prepare_timed(&mut encoder, frame, std::slice::from_ref(view), self.stamps.as_mut())?;
        let target = tile.texture.create_view(&Default::default());
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("sky"),
            color_attachments: &[Some(crate::phenomena::cleared(&target))],
            timestamp_writes: self.stamps.as_mut().and_then(|stamps| stamps.next("sky")),
            ..Default::default()
        });
        self.renderer.draw(&mut pass, 0);
        drop(pass);
        encoder.copy_texture_to_buffer(tile.texture.as_image_copy(), tile.as_destination(), tile.texture.size());
        let texel = self.renderer.exposure_texture();
        let one_row = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: None, rows_per_image: None };
        let destination = wgpu::TexelCopyBufferInfo { buffer: &tile.exposure, layout: one_row };
        encoder.copy_texture_to_buffer(texel.as_image_copy(), destination, texel.size());
        if let Some(stamps) = &self.stamps {
            stamps.resolve(&mut encoder);
        }
        self.gpu.queue.submit([encoder.finish()]);
        let reading = bytemuck::pod_read_unaligned(&self.gpu.read_buffer(&tile.exposure, tile.exposure.size())?);
        let times = match &mut self.stamps {
            Some(stamps) => stamps.read(&self.gpu)?,
            None => PassTimes::default(),
        };
        Ok((reading, times))
    }

    /// Copies the tile into its place, dropping alpha and what hangs over the edge.
    fn read_tile(&self, pixels: &mut Pixels, (width, height): (u32, u32), (x, y): (u32, u32)) -> Result<(), GpuError> {
        let Some(tile) = &self.tile else { return Err(GpuError::Device("no tile".into())) };
        let bytes = self.gpu.read_buffer(&tile.buffer, tile.buffer.size())?;
        let (w, h) = (tile.size.0.min(width - x) as usize, tile.size.1.min(height - y) as usize);
        for row in 0..h {
            let source = &bytes[row * tile.row_bytes as usize..];
            let start = ((y as usize + row) * width as usize + x as usize) * 3;
            match pixels {
                Pixels::Display(out) => {
                    for (to, from) in out[start..start + 3 * w].chunks_exact_mut(3).zip(source.chunks_exact(4)) {
                        to.copy_from_slice(&from[..3]);
                    }
                }
                Pixels::Radiance(out) => {
                    for (to, from) in out[start..start + 3 * w].chunks_exact_mut(3).zip(source.chunks_exact(16)) {
                        let rgba: [f32; 4] = bytemuck::pod_read_unaligned(from);
                        to.copy_from_slice(&rgba[..3]);
                    }
                }
            }
        }
        Ok(())
    }
}

impl Tile {
    fn new(gpu: &Gpu, size: (u32, u32), display: bool) -> Self {
        let (format, texel) =
            if display { (wgpu::TextureFormat::Rgba8Unorm, 4) } else { (wgpu::TextureFormat::Rgba32Float, 16) };
        let texture = gpu.device.create_texture(&wgpu::TextureDescriptor {
            label: Some("still tile"),
            size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        });
        let row_bytes = (size.0 * texel).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let buffer = |label, size| {
            gpu.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size,
                usage: wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        let tile_bytes = u64::from(row_bytes) * u64::from(size.1);
        Self {
            size,
            texture,
            row_bytes,
            buffer: buffer("still tile", tile_bytes),
            exposure: buffer("still exposure", 16),
        }
    }

    fn as_destination(&self) -> wgpu::TexelCopyBufferInfo<'_> {
        let layout =
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(self.row_bytes), rows_per_image: None };
        wgpu::TexelCopyBufferInfo { buffer: &self.buffer, layout }
    }
}
