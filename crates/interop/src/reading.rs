//! A policy's network out of an ONNX file: a normalizer, layers one after another, and the motion beside them.
//!
//! Policies of the field are chains: every operation has one input that is not constant. Others are refused by the
//! operation's name.

use std::collections::BTreeMap;

use lifelike_robot::RobotError;
use lifelike_robot::network::Layer;
use prost::Message;

use crate::mismatch;
use crate::proto::{Graph, Model, Node, Tensor};

/// A policy's file, taken apart.
#[derive(Debug, Clone)]
pub(crate) struct Reading {
    /// Named texts.
    pub(crate) metadata: BTreeMap<String, String>,
    /// Numbers of the observation.
    pub(crate) inputs: usize,
    /// Mean and deviation of each number of the observation, as the policy's normalizer has them; none without one.
    pub(crate) normalizer: Option<(Vec<f32>, Vec<f32>)>,
    /// Greatest normalized number.
    pub(crate) clip: Option<f32>,
    /// Layers with their weights and biases.
    pub(crate) layers: Vec<Weighted>,
    /// Arrays that `time_step` chooses from, by the output's name.
    pub(crate) motion: BTreeMap<String, (Vec<usize>, Vec<f32>)>,
}

/// A layer with its arrays; empty where it has none.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Weighted {
    pub(crate) layer: Layer,
    pub(crate) weight: Vec<f32>,
    pub(crate) bias: Vec<f32>,
}

/// The widest observation that is believed.
const WIDEST: usize = 1 << 16;

/// A limit beyond any number that a policy gives or takes.
const WIDE: f32 = 100.0;

/// Operations that change no number of a row.
const IDLE: [&str; 7] = ["Identity", "Flatten", "Squeeze", "Unsqueeze", "Reshape", "Concat", "Dropout"];

/// Returns a policy's file, taken apart. `path` is for messages.
///
/// # Errors
/// It is no ONNX file, or its network is no chain of known operations.
pub(crate) fn read(bytes: &[u8], path: &str) -> Result<Reading, RobotError> {
    let model = decoded(bytes, path)?;
    let Some(graph) = &model.graph else { return Err(mismatch(path, "an ONNX file with a network", "none")) };
    let metadata = texts(&model);
    let walk = Walk::new(graph, path);
    let names: Vec<&str> = graph.input.iter().filter_map(|input| input.name.as_deref()).collect();
    let observations: Vec<&str> = names.iter().copied().filter(|name| *name != "time_step").collect();
    let [name] = observations[..] else {
        return Err(mismatch(
            format!("{path}: inputs"),
            "one observation, and 'time_step' or nothing",
            names.join(", "),
        ));
    };
    let width =
        graph.input.iter().find(|input| input.name.as_deref() == Some(name)).and_then(crate::proto::Value::width);
    let Some(inputs) = width.filter(|width| (1..=WIDEST).contains(width)) else {
        return Err(mismatch(
            format!("{path}: input '{name}'"),
            format!("a width from 1 to {WIDEST}"),
            width.map_or("none".into(), |width| width.to_string()),
        ));
    };
    let outputs: Vec<&str> = graph.output.iter().filter_map(|output| output.name.as_deref()).collect();
    let Some(goal) = outputs.iter().copied().find(|name| ["actions", "action"].contains(name)) else {
        return Err(mismatch(format!("{path}: outputs"), "'actions'", outputs.join(", ")));
    };
    if let Some(node) = graph.node.iter().find(|node| !matches!(node.domain.as_deref(), None | Some("" | "ai.onnx"))) {
        let got =
            format!("'{}' of '{}'", node.op_type.as_deref().unwrap_or("?"), node.domain.as_deref().unwrap_or("?"));
        return Err(mismatch(format!("{path}: operations"), "ONNX's own", got));
    }
    let motion = walk.motion();
    let raw = walk.layers(name, goal, inputs)?;
    let (normalizer, clip, layers) = simplified(raw);
    Ok(Reading { metadata, inputs, normalizer, clip, layers, motion })
}

/// Returns the named texts of a file.
///
/// # Errors
/// It is no ONNX file.
pub(crate) fn metadata(bytes: &[u8], path: &str) -> Result<BTreeMap<String, String>, RobotError> {
    Ok(texts(&decoded(bytes, path)?))
}

fn decoded(bytes: &[u8], path: &str) -> Result<Model, RobotError> {
    if bytes.is_empty() {
        return Err(mismatch(path, "an ONNX file", "an empty file"));
    }
    Model::decode(bytes).map_err(|error| mismatch(path, "an ONNX file", error.to_string()))
}

fn texts(model: &Model) -> BTreeMap<String, String> {
    let text = |property: &crate::proto::Property| Some((property.key.clone()?, property.value.clone()?));
    model.metadata_props.iter().filter_map(text).collect()
}

/// A step of the chain.
#[derive(Debug, Clone)]
enum Step {
    Layer(Weighted),
    /// Numbers within ± this.
    Clip(f32),
    /// Numbers in another order: which stands at each place.
    Order(Vec<usize>),
}

struct Walk<'a> {
    graph: &'a Graph,
    constants: BTreeMap<&'a str, &'a Tensor>,
    path: &'a str,
}

impl<'a> Walk<'a> {
    fn new(graph: &'a Graph, path: &'a str) -> Self {
        let named = graph.initializer.iter().filter_map(|tensor| Some((tensor.name.as_deref()?, tensor)));
        let of_node = |node: &'a Node| {
            let value = node.attribute.iter().find(|a| a.name.as_deref() == Some("value"))?.t.as_ref()?;
            Some((node.output.first()?.as_str(), value))
        };
        let nodes = graph.node.iter().filter(|node| node.op_type.as_deref() == Some("Constant")).filter_map(of_node);
        Self { graph, constants: named.chain(nodes).collect(), path }
    }

    /// Arrays that outputs choose rows from.
    fn motion(&self) -> BTreeMap<String, (Vec<usize>, Vec<f32>)> {
        let gathers = self.graph.node.iter().filter(|node| node.op_type.as_deref() == Some("Gather"));
        let array = |node: &Node| {
            let tensor = self.constants.get(node.input.first()?.as_str())?;
            Some((node.output.first()?.clone(), (tensor.shape()?, tensor.values()?)))
        };
        gathers.filter_map(array).collect()
    }

    fn consumers(&self, name: &str) -> Vec<&'a Node> {
        self.graph.node.iter().filter(|node| node.input.iter().any(|input| input == name)).collect()
    }

    fn refused(&self, what: &str, nodes: &[&Node]) -> RobotError {
        let names: Vec<&str> = nodes.iter().filter_map(|node| node.op_type.as_deref()).collect();
        mismatch(
            format!("{}: network after '{what}'", self.path),
            "one of Gemm, MatMul, Add, Sub, Mul, Div, Elu, Relu, Tanh, Sigmoid with Mul, LayerNormalization, Clip, with finite \
             float32 constants of its width in this file, and plain settings",
            if names.is_empty() { "nothing that leads to 'actions'".into() } else { names.join(" and ") },
        )
    }

    /// Values of a constant, which are all finite.
    fn finite(&self, name: &str) -> Option<Vec<f32>> {
        self.constants.get(name)?.values().filter(|values| values.iter().all(|x| x.is_finite()))
    }

    /// Returns true where a reduction is over the numbers of a row.
    fn is_over_row(&self, node: &Node) -> bool {
        let setting = |name: &str| node.attribute.iter().find(|a| a.name.as_deref() == Some(name));
        let axes = match node.input.get(1) {
            Some(name) => self.finite(name).unwrap_or_default().iter().map(|axis| *axis as i64).collect(),
            None => setting("axes").map(|a| a.ints.clone()).unwrap_or_default(),
        };
        let keeps = setting("keepdims").and_then(|a| a.i).unwrap_or(1) == 1;
        keeps && (axes == [-1] || axes == [1])
    }

    /// Values of a constant, spread over a width.
    fn constant(&self, name: &str, width: usize) -> Option<Vec<f32>> {
        let values = self.finite(name)?;
        match values.len() {
            1 => Some(vec![values[0]; width]),
            n if n == width => Some(values),
            _ => None,
        }
    }

    /// The steps from an input to an output.
    fn layers(&self, input: &str, goal: &str, mut width: usize) -> Result<Vec<Step>, RobotError> {
        let (mut at, mut steps) = (input.to_string(), Vec::new());
        let limit = self.graph.node.len() + 1;
        for _ in 0..limit {
            let nodes = self.consumers(&at);
            if at == goal {
                return Ok(steps);
            }
            let refused = || self.refused(&at, &nodes);
            let next = match nodes[..] {
                [node] => self.single(node, &at, &mut width, &mut steps),
                [a, b] => self.pair(a, b, &at, width, &mut steps),
                _ => None,
            };
            at = next.ok_or_else(refused)?;
        }
        Err(self.refused(&at, &[]))
    }

    /// One operation; returns the name of its output.
    fn single(&self, node: &'a Node, x: &str, width: &mut usize, steps: &mut Vec<Step>) -> Option<String> {
        let (op, output) = (node.op_type.as_deref()?, node.output.first()?.clone());
        let input = |i: usize| node.input.get(i).map(String::as_str).filter(|name| !name.is_empty());
        let setting = |name: &str| node.attribute.iter().find(|a| a.name.as_deref() == Some(name));
        let plain = |layer: Layer| Step::Layer(Weighted { layer, weight: Vec::new(), bias: Vec::new() });
        let is_first = input(0) == Some(x);
        let other = || self.constant(input(usize::from(is_first))?, *width);
        let affine = |weight: Vec<f32>, bias: Vec<f32>| Step::Layer(Weighted { layer: Layer::Affine, weight, bias });
        let (ones, zeros) = (vec![1.0; *width], vec![0.0; *width]);
        let step = match op {
            "Add" => affine(ones, other()?),
            "Sub" if is_first => affine(ones, other()?.iter().map(|x| -x).collect()),
            "Sub" => affine(vec![-1.0; *width], other()?),
            "Mul" => affine(other()?, zeros),
            "Div" if is_first => affine(other()?.iter().map(|x| 1.0 / x).collect(), zeros),
            "Elu" if setting("alpha").is_none_or(|a| a.f == Some(1.0)) => plain(Layer::Elu),
            "Relu" => plain(Layer::Relu),
            "Tanh" => plain(Layer::Tanh),
            "LayerNormalization" => {
                let epsilon = setting("epsilon").and_then(|a| a.f).unwrap_or(1e-5);
                let weight = self.constant(input(1)?, *width)?;
                let bias = input(2).map_or(Some(zeros), |name| self.constant(name, *width))?;
                Step::Layer(Weighted { layer: Layer::LayerNorm { epsilon }, weight, bias })
            }
            "Gather" if setting("axis").and_then(|a| a.i) == Some(1) => {
                let order = self.constants.get(input(1)?)?.values()?;
                let mut seen = vec![false; *width];
                order.iter().for_each(|&i| seen.get_mut(i as usize).into_iter().for_each(|seen| *seen = true));
                let is_permutation = order.len() == *width && seen.iter().all(|seen| *seen);
                is_permutation.then(|| Step::Order(order.iter().map(|&i| i as usize).collect()))?
            }
            "Clip" => {
                let (low, high) = (self.constant(input(1)?, 1)?[0], self.constant(input(2)?, 1)?[0]);
                let early = steps.iter().all(|step| matches!(step, Step::Layer(Weighted { layer: Layer::Affine, .. })));
                // A limit wider than any number of a policy is none.
                (low == -high && high > 0.0 && (early || high >= WIDE)).then_some(Step::Clip(high))?
            }
            "Gemm" | "MatMul" if is_first => {
                let is_set = |name: &str| setting(name).and_then(|a| a.i).unwrap_or(0) == 1;
                let unit = |name: &str| setting(name).is_none_or(|a| a.f == Some(1.0));
                if is_set("transA") || !unit("alpha") || !unit("beta") {
                    return None;
                }
                let (shape, values) = (self.constants.get(input(1)?)?.shape()?, self.finite(input(1)?)?);
                let &[rows, columns] = &shape[..] else { return None };
                let (inputs, outputs) = if is_set("transB") { (columns, rows) } else { (rows, columns) };
                if inputs != *width {
                    return None;
                }
                let weight = if is_set("transB") { transposed(&values, rows, columns) } else { values };
                let bias = match input(2) {
                    Some(name) => self.constant(name, outputs)?,
                    None => vec![0.0; outputs],
                };
                *width = outputs;
                Step::Layer(Weighted { layer: Layer::Linear { outputs }, weight, bias })
            }
            "Slice" => {
                // Only one that takes everything.
                let (from, to) = (self.constant(input(1)?, 1)?[0], self.constant(input(2)?, 1)?[0]);
                return (from == 0.0 && to >= *width as f32).then_some(output);
            }
            // To single precision, which it is.
            "Cast" => return setting("to").is_some_and(|a| a.i == Some(1)).then_some(output),
            // With one input that is no constant these keep a row as it is.
            op if IDLE.contains(&op) => {
                let others =
                    node.input.iter().skip(1).all(|name| name.is_empty() || self.constants.contains_key(name.as_str()));
                let alone = op != "Concat" || node.input.len() == 1;
                return (others && alone).then_some(output);
            }
            _ => return None,
        };
        steps.push(step);
        Some(output)
    }

    /// Two operations on the same numbers: `x / (1 + exp(-x))`, or layer normalization in its parts.
    fn pair(&self, a: &'a Node, b: &'a Node, x: &str, width: usize, steps: &mut Vec<Step>) -> Option<String> {
        let node_of = |op: &str| [a, b].into_iter().find(|node| node.op_type.as_deref() == Some(op));
        let out = |node: &Node| node.output.first().cloned();
        let only = |name: &str, op: &str| {
            let nodes = self.consumers(name);
            nodes.iter().find(|node| node.op_type.as_deref() == Some(op)).filter(|_| nodes.len() <= 2).copied()
        };
        if let (Some(sigmoid), Some(product)) = (node_of("Sigmoid"), node_of("Mul")) {
            let takes = product.input.iter().any(|name| Some(name) == sigmoid.output.first());
            takes.then_some(())?;
            steps.push(Step::Layer(Weighted { layer: Layer::Silu, weight: Vec::new(), bias: Vec::new() }));
            return out(product);
        }
        let (mean, centred) = (node_of("ReduceMean")?, node_of("Sub")?);
        (centred.input == [x.to_string(), out(mean)?]).then_some(())?;
        let centred = out(centred)?;
        let (square, quotient) = (only(&centred, "Pow")?, only(&centred, "Div")?);
        (self.constant(square.input.get(1)?, 1)? == [2.0]).then_some(())?;
        let variance = only(&out(square)?, "ReduceMean")?;
        (self.is_over_row(mean) && self.is_over_row(variance)).then_some(())?;
        let sum = only(&out(variance)?, "Add")?;
        let epsilon = sum.input.iter().find_map(|name| self.constant(name, 1))?[0];
        let root = only(&out(sum)?, "Sqrt")?;
        (quotient.input.get(1)? == root.output.first()?).then_some(())?;
        let layer = Layer::LayerNorm { epsilon };
        steps.push(Step::Layer(Weighted { layer, weight: vec![1.0; width], bias: vec![0.0; width] }));
        out(quotient)
    }
}

fn transposed(values: &[f32], rows: usize, columns: usize) -> Vec<f32> {
    (0..columns).flat_map(|column| (0..rows).map(move |row| values[row * columns + column])).collect()
}

/// The rows of a weight for numbers that were not put in this order before it.
fn rows_back(weight: &[f32], order: &[usize]) -> Vec<f32> {
    let width = weight.len() / order.len().max(1);
    let mut rows = vec![0.0; weight.len()];
    for (row, place) in weight.chunks_exact(width.max(1)).zip(order) {
        rows[place * width..(place + 1) * width].copy_from_slice(row);
    }
    rows
}

/// A layer that puts numbers in another order.
fn permutation(order: &[usize]) -> Weighted {
    let width = order.len();
    let mut weight = vec![0.0; width * width];
    order.iter().enumerate().for_each(|(to, from)| weight[from * width + to] = 1.0);
    Weighted { layer: Layer::Linear { outputs: width }, weight, bias: vec![0.0; width] }
}

type Simplified = (Option<(Vec<f32>, Vec<f32>)>, Option<f32>, Vec<Weighted>);

/// Takes scales and shifts into the layers before them; those before the first layer are the normalizer.
fn simplified(steps: Vec<Step>) -> Simplified {
    let (mut normalizer, mut clip, mut layers) = (None, None, Vec::<Weighted>::new());
    let mut order: Option<Vec<usize>> = None;
    for step in steps {
        // Only a linear layer takes an order of its inputs into its rows.
        let is_linear = matches!(&step, Step::Layer(Weighted { layer: Layer::Linear { .. }, .. }));
        if !is_linear {
            layers.extend(order.take().map(|order| permutation(&order)));
        }
        match step {
            Step::Clip(limit) if limit < WIDE => clip = Some(limit),
            Step::Clip(_) => {}
            Step::Order(places) => order = Some(places),
            Step::Layer(Weighted { layer: Layer::Affine, weight, bias }) if layers.is_empty() && clip.is_none() => {
                let (scale, shift) =
                    normalizer.take().unwrap_or_else(|| (vec![1.0; weight.len()], vec![0.0; weight.len()]));
                let scale: Vec<f32> = scale.iter().zip(&weight).map(|(a, b)| a * b).collect();
                let shift = shift.iter().zip(&weight).zip(&bias).map(|((a, w), b)| a * w + b).collect();
                normalizer = Some((scale, shift));
            }
            Step::Layer(Weighted { layer: Layer::Affine, weight, bias }) => {
                let last = layers.last_mut().filter(|last| !last.bias.is_empty() && last.bias.len() == weight.len());
                let Some(last) = last else {
                    layers.push(Weighted { layer: Layer::Affine, weight, bias });
                    continue;
                };
                let width = weight.len();
                last.weight.iter_mut().enumerate().for_each(|(i, w)| *w *= weight[i % width]);
                last.bias.iter_mut().zip(&weight).zip(&bias).for_each(|((b, w), c)| *b = *b * w + c);
            }
            Step::Layer(mut layer) => {
                if let Some(order) = order.take() {
                    layer.weight = rows_back(&layer.weight, &order);
                }
                layers.push(layer);
            }
        }
    }
    layers.extend(order.map(|order| permutation(&order)));
    // scale x + shift = (x - mean) / deviation.
    let statistics = normalizer.map(|(scale, shift)| {
        let mean = scale.iter().zip(&shift).map(|(scale, shift)| -shift / scale).collect();
        (mean, scale.iter().map(|scale| 1.0 / scale).collect())
    });
    (statistics, clip, layers)
}
