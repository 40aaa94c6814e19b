//! Which stage reads and writes what.

use crate::buffers::Buffers;
use crate::slots::Slots;
use crate::stage::Slot::{Read, Texture, Uniform, Write};
use crate::stage::{PipelineMaker, Stage};
use common::Result;
use common::settings::{Drawing, Raster, Transport, Visibility};

/// The stages of a shot that is chosen on the device.
pub struct Pipelines {
    pub first: Stage,
    pub next: Stage,
    pub link: LinkStages,
    pub deposit: Stage,
    pub power: Stage,
}

/// What makes links, bound to one set of slots.
pub struct LinkStages {
    pub aim: Stage,
    pub whole: Stage,
    pub links: Stage,
    pub escape: Stage,
    pub received: Stage,
    pub closure: Stage,
    /// None where visibility is by rays.
    pub item_buffer: Option<ItemBufferStages>,
}

/// What draws item buffers.
pub struct ItemBufferStages {
    pub kind: Raster,
    pub tessellate: Stage,
    pub raster: wgpu::RenderPipeline,
    pub raster_group: wgpu::BindGroup,
}

impl Pipelines {
    pub fn new(
        maker: &PipelineMaker,
        transport: &Transport,
        b: &Buffers,
        s: &Slots,
    ) -> Result<Self> {
        let choice = [
            Uniform(&s.params),
            Read(&b.cells),
            Read(&b.sums),
            Read(&b.script),
            Read(&b.rows),
            Write(&s.shots),
            Write(&b.log),
            Write(&b.dispatches),
            Read(&b.lost),
        ];
        let deposit = [
            Read(&s.shots),
            Uniform(&s.params),
            Read(&b.texels),
            Read(&b.links),
            Write(&b.radiosity),
            Write(&b.residual),
            Write(&b.irradiance),
            Read(&s.samples),
        ];
        let power = [
            Uniform(&s.params),
            Read(&b.cells),
            Read(&b.texels),
            Read(&b.residual),
            Write(&b.sums),
        ];
        Ok(Self {
            first: maker.stage("select", "first", &choice)?,
            next: maker.stage("select", "next", &choice)?,
            link: LinkStages::new(maker, transport, b, s)?,
            deposit: maker.stage("deposit", "deposit", &deposit)?,
            power: maker.stage("power", "power", &power)?,
        })
    }
}

impl LinkStages {
    pub fn new(
        maker: &PipelineMaker,
        transport: &Transport,
        b: &Buffers,
        s: &Slots,
    ) -> Result<Self> {
        let rays = transport.visibility == Visibility::Rays;
        let item_buffer = match transport.visibility {
            Visibility::Rays => None,
            Visibility::Drawn(drawing) => Some(ItemBufferStages::new(maker, &drawing, b, s)?),
        };
        let aimed = [
            Uniform(&s.params),
            Read(&b.faces),
            Read(&b.points),
            Write(&s.shots),
            Write(&s.rectangles),
        ];
        let [escape, received, closure] = sums(maker, b, s)?;
        Ok(Self {
            aim: maker.stage("aim", "aim", &aimed)?,
            whole: maker.stage("aim", "whole", &aimed)?,
            links: links(maker, rays, b, s)?,
            escape,
            received,
            closure,
            item_buffer,
        })
    }
}

fn links(maker: &PipelineMaker, rays: bool, b: &Buffers, s: &Slots) -> Result<Stage> {
    let mut slots = vec![
        Read(&b.faces),
        Read(&s.shots),
        Uniform(&s.params),
        Read(&b.texels),
        Read(&b.points),
        Write(&s.samples),
        Write(&b.links),
    ];
    if rays {
        slots.extend([Read(&b.nodes), Read(&b.primitives)]);
    } else {
        // Without objects both are the one that is drawn.
        let room = s.room_buffer.as_ref().unwrap_or(&s.view);
        slots.extend([Texture(&s.view), Texture(room)]);
    }
    maker.stage("link", "links_of", &slots)
}

fn sums(maker: &PipelineMaker, b: &Buffers, s: &Slots) -> Result<[Stage; 3]> {
    let escape = [
        Read(&b.faces),
        Read(&s.shots),
        Uniform(&s.params),
        Read(&b.directions),
        Write(&b.lost),
        Read(&b.points),
        Read(&b.nodes),
        Read(&b.primitives),
    ];
    let received = [
        Uniform(&s.params),
        Read(&b.cells),
        Read(&b.texels),
        Read(&b.links),
        Read(&s.shots),
        Write(&s.taken),
    ];
    let closure = [
        Uniform(&s.params),
        Read(&s.taken),
        Write(&b.lost),
        Write(&b.rows),
        Write(&s.shots),
    ];
    Ok([
        maker.stage("escape", "escape", &escape)?,
        maker.stage("received", "received", &received)?,
        maker.stage("closure", "closure", &closure)?,
    ])
}

impl ItemBufferStages {
    fn new(maker: &PipelineMaker, drawing: &Drawing, b: &Buffers, s: &Slots) -> Result<Self> {
        let kind = drawing.projection.raster();
        let seen = [Read(&b.faces), Read(&s.shots), Uniform(&s.params)];
        let (raster, raster_group) = maker.raster(kind, &seen)?;
        let lists = [
            Read(&b.faces),
            Read(&s.shots),
            Uniform(&s.params),
            Write(&s.instances),
            Write(&s.draws),
        ];
        Ok(Self {
            kind,
            tessellate: maker.stage("tessellate", "tessellate", &lists)?,
            raster,
            raster_group,
        })
    }
}
