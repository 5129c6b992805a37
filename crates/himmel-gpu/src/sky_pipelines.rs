//! The sky's pipelines, by what their pixels have.

use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use crate::error::GpuError;
use crate::output::meter;
use crate::output::params::{OutputParams, Tonemap};
use crate::pass::module;
use crate::target::{Output, Target};
use crate::tiles::Needs;

/// The forms of the sky's pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Variant {
    /// Every pixel marches its ray.
    Marching,
    /// From the sky-view table: tiles far from lights and horizon.
    Plain,
    /// Tiles at the horizon, far from lights.
    Horizon,
    /// Tiles near a light, off the horizon.
    Aureole,
    /// Tiles near a light and at the horizon.
    Both,
    /// Tiles with the Moon, off the horizon and far from lights.
    Moon,
    /// Tiles with the Moon near a light, off the horizon.
    MoonInAureole,
    /// Tiles with a disc.
    Everything,
    /// The metering picture, marching.
    MeteringMarch,
    /// The metering picture from the table.
    MeteringTable,
    /// Rectangles with other bodies, marching.
    Bodies,
    /// The same over a sky from the table.
    BodiesTable,
    /// The same in the metering picture.
    MeteringBodies,
    /// The same over a metering picture from the table.
    MeteringBodiesTable,
}

impl Variant {
    /// Those that draw a picture from the table together, in the order of [`Needs::SETS`].
    pub(crate) const TILED: [Self; 7] =
        [Self::Plain, Self::Horizon, Self::Aureole, Self::Both, Self::Moon, Self::MoonInAureole, Self::Everything];

    pub(crate) fn tiled(self) -> bool {
        Self::TILED.contains(&self)
    }

    pub(crate) fn marching(self) -> bool {
        matches!(self, Self::Marching | Self::MeteringMarch | Self::Bodies | Self::MeteringBodies)
    }

    pub(crate) fn metering(self) -> bool {
        let bodies = matches!(self, Self::MeteringBodies | Self::MeteringBodiesTable);
        bodies || matches!(self, Self::MeteringMarch | Self::MeteringTable)
    }

    pub(crate) fn bodies(self) -> bool {
        matches!(self, Self::Bodies | Self::BodiesTable | Self::MeteringBodies | Self::MeteringBodiesTable)
    }

    /// What its pixels have.
    pub(crate) fn has(self) -> Needs {
        let set = Self::TILED.iter().position(|variant| *variant == self);
        set.map_or(Needs::ALL, |set| Needs::SETS[set])
    }
}

/// What pipelines with the Moon differ in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct MoonKind {
    /// Points along a pixel's side.
    pub side: u32,
    /// Relief of its ground: 0 none, 1 by normals, 2 by heights.
    pub relief: u32,
    /// Whether the Earth's shadow is near.
    pub eclipsed: bool,
}

/// The sky's pipelines, made when they are first needed.
pub(crate) struct Pipelines {
    device: wgpu::Device,
    target: Target,
    layout: wgpu::PipelineLayout,
    module: wgpu::ShaderModule,
    /// Of the air in hand.
    constants: [(&'static str, f64); 2],
    /// What draws other bodies, once there are some.
    far: Option<FarPipelines>,
    made: Mutex<Made>,
}

/// Layout, module and constants of the pipelines of other bodies.
struct FarPipelines {
    layout: wgpu::PipelineLayout,
    module: wgpu::ShaderModule,
    constants: [(&'static str, f64); 2],
}

type Made = HashMap<(Variant, Kind), wgpu::RenderPipeline>;

/// What else pipelines differ in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct Kind {
    /// Whether the projection is a matrix.
    pub linear: bool,
    /// Lights of the frame.
    pub lights: u32,
    /// How finished pictures are tone mapped.
    pub tonemap: Tonemap,
    /// Whether something stands before the Sun for the air …
    pub eclipsed: bool,
    /// … and for its disc.
    pub occluded: bool,
    /// Whether the Moon is in the picture: asked by pipelines that may draw it only.
    pub moon: Option<MoonKind>,
    /// Whether the night glows.
    pub night: bool,
    /// Whether pipelines without horizon read its glow from the grid.
    pub grid: bool,
    /// Whether pixels read points from bins.
    pub points: bool,
    /// Whether points have glare.
    pub glare: bool,
}

impl Pipelines {
    /// None yet.
    pub(crate) fn new(
        device: &wgpu::Device,
        target: &Target,
        layout: wgpu::PipelineLayout,
        module: wgpu::ShaderModule,
        constants: [(&'static str, f64); 2],
    ) -> Self {
        Self { device: device.clone(), target: *target, layout, module, constants, far: None, made: Mutex::default() }
    }

    /// Takes the constants of another air; true if they are new, and all pipelines with them.
    pub(crate) fn set_constants(&mut self, constants: [(&'static str, f64); 2]) -> bool {
        let new = self.constants != constants;
        if new {
            self.constants = constants;
            self.made = Mutex::default();
        }
        new
    }

    /// Whether other bodies can be drawn.
    pub(crate) fn has_far(&self) -> bool {
        self.far.is_some()
    }

    /// Makes what the next frame of a matrix projection needs.
    pub(crate) fn make(&self, marching: bool) {
        let variants: &[Variant] = if marching { &[Variant::Marching] } else { &Variant::TILED };
        for variant in variants.iter().filter(|variant| !matches!(variant, Variant::Moon | Variant::MoonInAureole)) {
            self.get(
                *variant,
                Kind {
                    linear: true,
                    lights: 1,
                    tonemap: OutputParams::default().tonemap,
                    eclipsed: false,
                    night: false,
                    grid: false,
                    points: false,
                    glare: false,
                    occluded: false,
                    moon: None,
                },
            );
        }
    }

    pub(crate) fn make_far(
        &mut self,
        groups: [&wgpu::BindGroupLayout; 3],
        constants: [(&'static str, f64); 2],
    ) -> Result<(), GpuError> {
        let module = module(&self.device, "phenomena/bodies/bodies.wgsl")?;
        let layout = self.device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("bodies"),
            bind_group_layouts: &groups.map(Some),
            immediate_size: 0,
        });
        self.far = Some(FarPipelines { layout, module, constants });
        Ok(())
    }

    /// Values of overrides for all airs.
    pub(crate) fn far_constants(&mut self, constants: [(&'static str, f64); 2]) {
        let Some(far) = &mut self.far else { return };
        if far.constants != constants {
            far.constants = constants;
            let made = self.made.get_mut().unwrap_or_else(PoisonError::into_inner);
            made.retain(|(variant, _), _| !variant.bodies());
        }
    }

    pub(crate) fn get(&self, variant: Variant, kind: Kind) -> wgpu::RenderPipeline {
        let has = variant.has();
        let kind = Kind {
            moon: kind.moon.filter(|_| has.moon),
            grid: kind.grid && variant.tiled() && !has.horizon,
            points: kind.points && !variant.metering() && !variant.bodies(),
            glare: kind.glare && !variant.metering() && !variant.bodies(),
            ..kind
        };
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let pipeline = made.entry((variant, kind)).or_insert_with(|| {
            let metering = Target::new(meter::FORMAT, Output::Radiance);
            let target = if variant.metering() { &metering } else { &self.target };
            let far = self.far.as_ref().filter(|_| variant.bodies());
            let own = (&self.module, &self.layout, self.constants);
            let (module, layout, constants) = far.map_or(own, |far| (&far.module, &far.layout, far.constants));
            sky_pipeline(&self.device, module, layout, target, variant, kind, constants)
        });
        pipeline.clone()
    }
}

fn sky_pipeline(
    device: &wgpu::Device,
    module: &wgpu::ShaderModule,
    layout: &wgpu::PipelineLayout,
    target: &Target,
    variant: Variant,
    kind: Kind,
    [groups, aerosols]: [(&'static str, f64); 2],
) -> wgpu::RenderPipeline {
    let on = |yes: bool| f64::from(u8::from(yes));
    let Needs { horizon, aureole, disc, moon: _ } = variant.has();
    let marching = ("marching", on(variant.marching()));
    let metering = ("metering", on(variant.metering()));
    let vertex_constants = vec![
        ("tiled", on(variant.tiled())),
        ("far_depth", target.far_depth()),
        ("light_count", f64::from(kind.lights)),
        ("with_moon", on(kind.moon.is_some())),
        ("with_horizon", on(horizon)),
        marching,
        metering,
        groups,
        aerosols,
    ];
    let constants = vec![
        ("with_horizon", on(horizon)),
        ("with_aureole", on(aureole)),
        ("with_disc", on(disc)),
        ("linear", on(kind.linear)),
        ("finished", on(target.output == Output::Display)),
        ("light_count", f64::from(kind.lights)),
        ("eclipses", on(kind.eclipsed)),
        ("night", on(kind.night)),
        ("night_grid", on(kind.grid)),
        ("with_points", on(kind.points)),
        ("with_glare", on(kind.glare)),
        ("occluded", on(kind.occluded)),
        ("with_moon", on(kind.moon.is_some())),
        ("tonemap_operator", f64::from(kind.tonemap as u32)),
        ("target_is_srgb", on(target.colour.is_srgb())),
        marching,
        metering,
        groups,
        aerosols,
    ];
    let constants = constants.into_iter().chain(kind.moon.into_iter().flat_map(|moon| {
        [
            ("moon_side", f64::from(moon.side)),
            ("moon_relief", f64::from(moon.relief)),
            ("moon_eclipsed", on(moon.eclipsed)),
        ]
    }));
    let mut constants: Vec<_> = constants.collect();
    let [vertex_entry, fragment_entry] = match variant.bodies() {
        false => ["sky_vertex", "sky_fragment"],
        true => {
            constants.push(("far_airs", 1.0));
            ["bodies_vertex", "bodies_fragment"]
        }
    };
    let options = |constants| wgpu::PipelineCompilationOptions { constants, ..Default::default() };
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(match (variant.bodies(), variant.metering()) {
            (true, _) => "bodies",
            (false, true) => "sky, metering",
            (false, false) => "sky",
        }),
        layout: Some(layout),
        vertex: wgpu::VertexState {
            module,
            entry_point: Some(vertex_entry),
            compilation_options: options(&vertex_constants),
            buffers: &[],
        },
        primitive: Default::default(),
        depth_stencil: target.behind(),
        multisample: wgpu::MultisampleState { count: target.samples, ..Default::default() },
        fragment: Some(wgpu::FragmentState {
            module,
            entry_point: Some(fragment_entry),
            compilation_options: options(&constants),
            targets: &[Some(target.colour.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}
