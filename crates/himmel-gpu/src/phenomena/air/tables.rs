//! The air's tables on the GPU, integrated in f64 by `himmel-air` and uploaded when the medium changes.

use himmel_air::Atmosphere;
use himmel_air::atmosphere::IRRADIANCE_WIDTH;

/// Altitudes of the medium, spaced as √(h / top).
const ALTITUDES: usize = 256;
/// Scattering angles, spaced as √(θ / π): crowded in the forward peak.
const ANGLES: usize = 256;

/// The four tables.
pub(crate) struct Tables {
    extinction: wgpu::Texture,
    scattering: wgpu::Texture,
    optical_depth: wgpu::Texture,
    irradiance: wgpu::Texture,
}

impl Tables {
    pub(crate) fn new(device: &wgpu::Device, depth_size: (usize, usize)) -> Self {
        let texture = |label, width: usize, height: usize| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: width as u32, height: height as u32, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format: wgpu::TextureFormat::Rgba32Float,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
                view_formats: &[],
            })
        };
        Self {
            extinction: texture("extinction", ALTITUDES, 1),
            scattering: texture("scattering", ANGLES, ALTITUDES),
            optical_depth: texture("optical depth", depth_size.0, depth_size.1),
            irradiance: texture("irradiance", IRRADIANCE_WIDTH, 1),
        }
    }

    /// Views in the order of the bindings 1 to 4.
    pub(crate) fn views(&self) -> [wgpu::TextureView; 4] {
        [&self.extinction, &self.scattering, &self.optical_depth, &self.irradiance]
            .map(|texture| texture.create_view(&Default::default()))
    }

    /// Memory of the tables in bytes.
    pub(crate) fn bytes(&self) -> u64 {
        [&self.extinction, &self.scattering, &self.optical_depth, &self.irradiance]
            .iter()
            .map(|texture| u64::from(texture.width()) * u64::from(texture.height()) * 16)
            .sum()
    }

    pub(crate) fn upload(&self, queue: &wgpu::Queue, atmosphere: &Atmosphere) {
        let air = atmosphere.sampled();
        let medium = atmosphere.medium();
        let altitude_m = |y: usize| medium.top_altitude_m * (y as f64 / (ALTITUDES - 1) as f64).powi(2);
        let extinction: Vec<[f32; 4]> = (0..ALTITUDES).map(|y| narrow(air.extinction_per_m(altitude_m(y)))).collect();
        write(queue, &self.extinction, &extinction);

        let phases: Vec<Vec<[f64; 4]>> = (0..ANGLES)
            .map(|x| air.phases((std::f64::consts::PI * (x as f64 / (ANGLES - 1) as f64).powi(2)).cos()))
            .collect();
        let mut scattering = Vec::with_capacity(ANGLES * ALTITUDES);
        for y in 0..ALTITUDES {
            let density: Vec<f64> = medium.components.iter().map(|c| c.profile.at(altitude_m(y))).collect();
            for phase in &phases {
                let mut sum = [0.0; 4];
                for (c, component) in air.components.iter().enumerate() {
                    for k in 0..4 {
                        sum[k] += density[c] * component.scattering_per_m[k] * phase[c][k];
                    }
                }
                scattering.push(narrow(sum));
            }
        }
        write(queue, &self.scattering, &scattering);

        let (width, height) = atmosphere.depth_size();
        let log2 = |depth: [f64; 4]| narrow(depth.map(|tau| tau.max(1e-30).log2()));
        let mut depths = Vec::with_capacity(width * height);
        for y in 0..height {
            depths.extend((0..width).map(|x| log2(atmosphere.depth_at_node(&air, x, y))));
        }
        write(queue, &self.optical_depth, &depths);
        let irradiance: Vec<[f32; 4]> = atmosphere.ground_sky_irradiance().iter().map(|e| log2(*e)).collect();
        write(queue, &self.irradiance, &irradiance);
    }
}

fn narrow(values: [f64; 4]) -> [f32; 4] {
    values.map(|value| value as f32)
}

fn write(queue: &wgpu::Queue, texture: &wgpu::Texture, texels: &[[f32; 4]]) {
    let layout =
        wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(texture.width() * 16), rows_per_image: None };
    queue.write_texture(texture.as_image_copy(), bytemuck::cast_slice(texels), layout, texture.size());
}
