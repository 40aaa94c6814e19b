//! The loop, its passes and iterations, and its balance of energy.

mod energy;
mod invariants;
mod iterations;
mod order;
mod painted;
mod passes;
mod soft;
