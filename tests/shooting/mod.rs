//! Tests of the shooting loop, of iterations by passes, and of the energy balance.

mod energy;
mod iterations;
mod order;
mod painted;
mod passes;
mod soft;
mod trace;
