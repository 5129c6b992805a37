//! The air's tables on the GPU. Densities and peaks come from `himmel-air`; all else is computed here from them.

use himmel_air::Atmosphere;
use himmel_air::eclipse::{CROSSING, INSIDE};
use himmel_air::moments::{Prepared, sun_columns};
use sha2::{Digest, Sha256};

use super::saved::Part;
use super::sizes::AirSizes;
use super::uniform::{AirUniform, MOST_BODIES};
use crate::error::GpuError;

/// Rows of the density table: four for sixteen species, one for the columns of the moment table.
const DENSITY_ROWS: u32 = 5;

/// The tables of all bodies: one layer (or several) for each. The first is the one that the camera stands on or above.
pub(crate) struct Tables {
    pub uniforms: wgpu::Buffer,
    pub density: wgpu::Texture,
    pub depth: wgpu::Texture,
    pub moments: wgpu::Texture,
    pub peaks: wgpu::Texture,
    pub ground: wgpu::Texture,
    airs: Vec<AirUniform>,
    /// Of what was uploaded for each body.
    fingerprints: Vec<[u8; 32]>,
}

impl Tables {
    /// Room for `bodies` bodies with `aerosols` aerosols in all.
    pub(crate) fn new(device: &wgpu::Device, sizes: &AirSizes, bodies: u32, aerosols: u32) -> Self {
        let texture = |label, [width, height]: [u32; 2], layers: u32, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: layers.max(1) },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC | usage,
                view_formats: &[],
            })
        };
        let quality = &sizes.moments;
        let (rows, columns) = (quality.rows as u32, quality.columns as u32);
        let peaks = [quality.peak_angles as u32, 2 * quality.peak_depths as u32 + 2];
        let (uploaded, computed) = (wgpu::TextureUsages::COPY_DST, wgpu::TextureUsages::STORAGE_BINDING);
        let both = uploaded | computed;
        let uniforms = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("airs"),
            size: (MOST_BODIES * size_of::<AirUniform>()) as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            uniforms,
            density: texture("densities", [sizes.densities, DENSITY_ROWS], bodies, uploaded),
            depth: texture("optical depth", sizes.depth, 2 * bodies, both),
            moments: texture("moments", [columns, rows], 6 * bodies, both),
            peaks: texture("peaks", peaks, aerosols, uploaded),
            ground: texture("ground irradiance", [columns, bodies.max(2)], 1, both),
            airs: vec![AirUniform::default(); MOST_BODIES],
            fingerprints: vec![[0; 32]; MOST_BODIES],
        }
    }

    /// Uploads the medium of a body. `first_layer`: where its aerosols' peaks lie.
    pub(crate) fn upload(
        &mut self,
        queue: &wgpu::Queue,
        body: usize,
        atmosphere: &Atmosphere,
        prepared: &Prepared,
        first_layer: usize,
    ) -> Result<(), GpuError> {
        self.airs[body] = AirUniform::new(atmosphere, prepared, first_layer)?;
        queue.write_buffer(&self.uniforms, 0, bytemuck::cast_slice(&self.airs));
        // Where its peaks lie among those of other bodies is no part of an air.
        let alone = AirUniform::new(atmosphere, prepared, 0)?;
        let mut fingerprint = Sha256::new_with_prefix(bytemuck::bytes_of(&alone));
        let (medium, width) = (atmosphere.medium(), self.density.width() as usize);
        let altitude_m = |x: usize| medium.top_altitude_m * (x as f64 / (width - 1) as f64).powi(2);
        let mut density = vec![[0f32; 4]; width * DENSITY_ROWS as usize];
        for (index, species) in prepared.species.iter().enumerate() {
            for x in 0..width {
                density[index / 4 * width + x][index % 4] = species.profile.at(altitude_m(x)) as f32;
            }
        }
        for x in 0..width {
            let suns = sun_columns(medium.bottom_radius_m, medium.top_altitude_m, altitude_m(x));
            density[(DENSITY_ROWS as usize - 1) * width + x] = suns.map(|value| value as f32);
        }
        write(queue, &self.density, body, &density);
        fingerprint.update(bytemuck::cast_slice(&density));
        let (angles, depths) = (prepared.angles, prepared.depths);
        for (index, aerosol) in prepared.aerosols.iter().enumerate() {
            let mut texels = Vec::with_capacity(angles * (2 * depths + 2));
            for form in &aerosol.corrections_per_sr {
                for depth in 0..depths {
                    texels.extend((0..angles).map(|angle| form[angle * depths + depth].map(|value| value as f32)));
                }
            }
            for row in [&aerosol.phase_per_sr, &prepared.mean_phase_per_sr] {
                texels.extend(row.iter().map(|phase| phase.map(|value| value as f32)));
            }
            write(queue, &self.peaks, first_layer + index, &texels);
            fingerprint.update(bytemuck::cast_slice(&texels));
        }
        self.fingerprints[body] = fingerprint.finalize().into();
        Ok(())
    }

    /// Takes over what another one holds, as far as there is room; `bodies` of them stay.
    pub(crate) fn take(&mut self, device: &wgpu::Device, queue: &wgpu::Queue, old: &Self, bodies: usize) {
        let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("air tables") });
        let pairs = [
            (&old.density, &self.density),
            (&old.depth, &self.depth),
            (&old.moments, &self.moments),
            (&old.peaks, &self.peaks),
            (&old.ground, &self.ground),
        ];
        for (from, to) in pairs {
            let least = |size: fn(&wgpu::Texture) -> u32| size(from).min(size(to));
            let size = wgpu::Extent3d {
                width: least(wgpu::Texture::width),
                height: least(wgpu::Texture::height),
                depth_or_array_layers: least(wgpu::Texture::depth_or_array_layers),
            };
            encoder.copy_texture_to_texture(from.as_image_copy(), to.as_image_copy(), size);
        }
        queue.submit([encoder.finish()]);
        self.airs[..bodies].copy_from_slice(&old.airs[..bodies]);
        self.fingerprints[..bodies].copy_from_slice(&old.fingerprints[..bodies]);
        queue.write_buffer(&self.uniforms, 0, bytemuck::cast_slice(&self.airs));
    }

    /// Bodies and aerosols that there is room for.
    pub(crate) fn room(&self) -> (u32, u32) {
        (self.density.depth_or_array_layers(), self.peaks.depth_or_array_layers())
    }

    /// Of everything that was uploaded for a body.
    pub(crate) fn fingerprint(&self, body: usize) -> &[u8; 32] {
        &self.fingerprints[body]
    }

    /// What is computed from it: the tables that can be saved.
    pub(crate) fn computed(&self, body: usize) -> [Part<'_>; 3] {
        let layers = |texture, count: u32| Part::layers(texture, count * body as u32, count);
        [layers(&self.depth, 2), layers(&self.moments, 6), Part::row(&self.ground, body as u32)]
    }

    /// Values of the shaders' overrides for the airs of some bodies, see `medium.wgsl`.
    pub(crate) fn constants(&self, bodies: std::ops::Range<usize>) -> [(&'static str, f64); 2] {
        let airs = self.airs.get(bodies).unwrap_or_default();
        let most = |count: &dyn Fn(&AirUniform) -> u32| f64::from(airs.iter().map(count).max().unwrap_or(0));
        [
            ("species_groups", most(&|air| air.species_count.div_ceil(4)).max(1.0)),
            ("aerosols", most(&|air| air.aerosol_count)),
        ]
    }

    /// Memory of the tables in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        [&self.density, &self.depth, &self.moments, &self.peaks, &self.ground].into_iter().map(texture_bytes).sum()
    }
}

/// Memory of a texture in bytes.
pub(crate) fn texture_bytes(texture: &wgpu::Texture) -> u64 {
    let texel = u64::from(texture.format().block_copy_size(None).unwrap_or(0));
    u64::from(texture.width()) * u64::from(texture.height()) * u64::from(texture.depth_or_array_layers()) * texel
}

pub(crate) fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, layer: usize, texels: &[[f32; 4]]) {
    let (width, height) = (texture.width(), texture.height());
    let target = wgpu::TexelCopyTextureInfo {
        origin: wgpu::Origin3d { x: 0, y: 0, z: layer as u32 },
        ..texture.as_image_copy()
    };
    let layout = wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(width * 16), rows_per_image: None };
    let size = wgpu::Extent3d { width, height, depth_or_array_layers: 1 };
    queue.write_texture(target, bytemuck::cast_slice(texels), layout, size);
}

/// Room for the eclipse table.
pub(crate) fn eclipse_texture(device: &wgpu::Device) -> wgpu::Texture {
    device.create_texture(&wgpu::TextureDescriptor {
        label: Some("eclipse"),
        size: wgpu::Extent3d { width: (INSIDE + CROSSING) as u32, height: 1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: wgpu::TextureFormat::Rgba32Float,
        usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
        view_formats: &[],
    })
}
