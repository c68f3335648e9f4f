//! Chooses the nodes of a phase table: a graded grid, halved until every midpoint agrees with the exact value.

use std::f64::consts::{FRAC_PI_2, PI};

use super::phase_shape::{Interpolation, ln_slopes};
use super::phase_table::PhaseTable;

/// Most nodes of a table; 32 bytes each. Reached by single spheres of x above 1500 or so, whose angular fringes
/// are pi/x apart; the worst intervals, weighted by the light they hold, are refined first.
pub const MAX_NODES: usize = 32_768;

/// First step of the starting grid in units of 1/x: six steps to the first dark ring at 3.8/x.
const FIRST_STEP: f64 = 0.7;

/// Growth of the starting grid's steps with the angle from 0 or pi.
const GROWTH: f64 = 0.2;

/// Longest step of the starting grid, rad: bows and glories are found from a few degrees away.
const LONGEST_STEP: f64 = 0.1;

/// Neighbours wider than this many times a refined interval are refined with it: a spline through nodes that are
/// spaced more unevenly swings.
const GRADING: f64 = 1.5;

/// What a table is built to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TableAccuracy {
    /// Relative error of p between nodes.
    pub tolerance: f64,
    /// Most nodes.
    pub max_nodes: usize,
}

/// A table and how well it was reached.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltTable {
    /// The table.
    pub table: PhaseTable,
    /// Largest relative error of p that was seen at the midpoints of the final intervals.
    pub error: f64,
}

/// Builds a table of a function of the scattering angle, in any unit, whose finest structure is about pi / `x`.
///
/// `values_at` is asked for batches of angles in rad; `None` where no value is above zero and finite.
///
/// # Errors
/// Those of `values_at`.
pub fn build_adaptive<E>(
    x: f64,
    accuracy: TableAccuracy,
    mut values_at: impl FnMut(&[f64]) -> Result<Vec<f64>, E>,
) -> Result<Option<BuiltTable>, E> {
    let mut grid = Grid::start(x, &mut values_at)?;
    loop {
        grid.measure_middles(&mut values_at)?;
        let errors = grid.errors();
        let split = grid.choose(&errors, accuracy);
        if !split.contains(&true) {
            let error = errors.iter().copied().fold(0.0, f64::max);
            let (s, values) = grid.nodes.iter().map(|node| (node.s, node.value)).unzip();
            let values: Vec<f64> = values;
            let table = PhaseTable::from_nodes(s, &values, Interpolation::Spline);
            return Ok(table.map(|table| BuiltTable { table, error }));
        }
        grid.split(&split);
    }
}

#[derive(Clone, Copy, Debug)]
struct Node {
    theta: f64,
    s: f64,
    value: f64,
}

impl Node {
    fn new(theta: f64, value: f64) -> Self {
        Self { theta, s: (0.5 * theta).sin(), value }
    }

    /// Logarithm, with a floor that keeps a zero apart from everything else.
    fn ln(&self) -> f64 {
        self.value.max(f64::MIN_POSITIVE).ln()
    }
}

/// Nodes with what is known about the middles of their intervals.
struct Grid {
    nodes: Vec<Node>,
    middles: Vec<Option<Node>>,
}

impl Grid {
    fn start<E>(x: f64, values_at: &mut impl FnMut(&[f64]) -> Result<Vec<f64>, E>) -> Result<Self, E> {
        let theta = starting_angles(x);
        let values = values_at(&theta)?;
        let nodes: Vec<Node> = theta.iter().zip(values).map(|(theta, value)| Node::new(*theta, value)).collect();
        let middles = vec![None; nodes.len() - 1];
        Ok(Self { nodes, middles })
    }

    /// Asks for the values in the middles that are not known yet.
    fn measure_middles<E>(&mut self, values_at: &mut impl FnMut(&[f64]) -> Result<Vec<f64>, E>) -> Result<(), E> {
        let unknown: Vec<usize> = (0..self.middles.len()).filter(|i| self.middles[*i].is_none()).collect();
        let middle = |i: &usize| 0.5 * (self.nodes[*i].theta + self.nodes[*i + 1].theta);
        let theta: Vec<f64> = unknown.iter().map(middle).collect();
        let values = values_at(&theta)?;
        for ((i, theta), value) in unknown.into_iter().zip(theta).zip(values) {
            self.middles[i] = Some(Node::new(theta, value));
        }
        Ok(())
    }

    /// Relative error of the spline at every middle.
    fn errors(&self) -> Vec<f64> {
        let s: Vec<f64> = self.nodes.iter().map(|node| node.s).collect();
        let y: Vec<f64> = self.nodes.iter().map(Node::ln).collect();
        let slopes = ln_slopes(&s, &y, Interpolation::Spline);
        let error = |(i, middle): (usize, &Option<Node>)| {
            let Some(middle) = middle else { return 0.0 };
            let width = s[i + 1] - s[i];
            let z = (middle.s - s[i]) / width;
            let (rise, d0, d1) = (y[i + 1] - y[i], width * slopes[i], width * slopes[i + 1]);
            let y_z = y[i] + z * (d0 + z * (3.0 * rise - 2.0 * d0 - d1 + z * (d0 + d1 - 2.0 * rise)));
            let error = (y_z - middle.ln()).exp_m1().abs();
            if error.is_finite() { error } else { 0.0 }
        };
        self.middles.iter().enumerate().map(error).collect()
    }

    /// The intervals to be halved: those above the tolerance and their much wider neighbours, as far as nodes are left.
    fn choose(&self, errors: &[f64], accuracy: TableAccuracy) -> Vec<bool> {
        let width = |i: usize| self.nodes[i + 1].theta - self.nodes[i].theta;
        // An interval of a few roundings of pi cannot be halved.
        let mut failing: Vec<usize> =
            (0..errors.len()).filter(|i| errors[*i] > accuracy.tolerance && width(*i) > 1e-14).collect();
        let left = accuracy.max_nodes.saturating_sub(self.nodes.len());
        let mut split = vec![false; errors.len()];
        if failing.len() > left {
            let light = |i: usize| errors[i] * self.nodes[i].value * self.nodes[i].theta.sin() * width(i);
            failing.sort_by(|a, b| light(*b).total_cmp(&light(*a)).then(a.cmp(b)));
            failing.truncate(left);
        }
        failing.iter().for_each(|i| split[*i] = true);
        if 3 * failing.len() <= left {
            for i in failing {
                for neighbour in [i.wrapping_sub(1), i + 1] {
                    if neighbour < split.len() && width(neighbour) > GRADING * width(i) {
                        split[neighbour] = true;
                    }
                }
            }
        }
        split
    }

    fn split(&mut self, split: &[bool]) {
        let (mut nodes, mut middles) = (vec![self.nodes[0]], Vec::new());
        for (i, is_split) in split.iter().enumerate() {
            match self.middles[i] {
                Some(middle) if *is_split => {
                    nodes.push(middle);
                    middles.extend([None, None]);
                }
                known => middles.push(known),
            }
            nodes.push(self.nodes[i + 1]);
        }
        (self.nodes, self.middles) = (nodes, middles);
    }
}

/// Angles from 0 to pi, symmetric about pi/2, fine at both ends.
fn starting_angles(x: f64) -> Vec<f64> {
    let first = (FIRST_STEP / x).min(LONGEST_STEP);
    let mut half = vec![0.0];
    let mut theta = 0.0;
    loop {
        theta += (GROWTH * theta).clamp(first, LONGEST_STEP);
        if theta >= FRAC_PI_2 - 0.5 * LONGEST_STEP {
            break;
        }
        half.push(theta);
    }
    let mirrored: Vec<f64> = half.iter().rev().map(|theta| PI - theta).collect();
    half.into_iter().chain([FRAC_PI_2]).chain(mirrored).collect()
}
