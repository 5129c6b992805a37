//! One folder for each thing you can see.

pub mod air;
pub mod bodies;
pub mod ground;
pub mod moon;
pub mod night_glow;
pub mod overlay;
pub mod planets;
pub mod stars;
pub mod sun;

/// A colour attachment that starts black.
pub(crate) fn cleared(view: &wgpu::TextureView) -> wgpu::RenderPassColorAttachment<'_> {
    wgpu::RenderPassColorAttachment {
        view,
        depth_slice: None,
        resolve_target: None,
        ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
    }
}
