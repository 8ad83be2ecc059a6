//! A network as ONNX's operations.

use lifelike_checkpoint::Checkpoint;
use lifelike_robot::controller::ControllerHeader;
use lifelike_robot::network::Layer;
use lifelike_robot::{ActionSpec, RobotError};

use crate::proto::{Attribute, Graph, Node, Tensor, Value};

/// An ONNX network in the making.
#[derive(Debug, Default)]
pub(crate) struct Builder {
    pub(crate) graph: Graph,
    names: usize,
}

impl Builder {
    pub(crate) fn input(&mut self, name: &str, shape: &[usize]) {
        self.graph.input.push(Value::floats(name, shape));
    }

    pub(crate) fn output(&mut self, name: &str, shape: &[usize]) {
        self.graph.output.push(Value::floats(name, shape));
    }

    pub(crate) fn floats(&mut self, name: &str, shape: &[usize], values: &[f32]) -> String {
        self.graph.initializer.push(Tensor::floats(name, shape, values));
        name.into()
    }

    pub(crate) fn whole(&mut self, name: &str, shape: &[usize], values: &[i64]) -> String {
        self.graph.initializer.push(Tensor::whole(name, shape, values));
        name.into()
    }

    /// Adds an operation, whose output gets a name of its own.
    pub(crate) fn node(&mut self, op: &str, inputs: &[&str], attributes: &[Attribute]) -> String {
        self.names += 1;
        let output = format!("{}_{}", op.to_lowercase(), self.names);
        self.graph.node.push(Node {
            input: inputs.iter().map(|&name| name.into()).collect(),
            output: vec![output.clone()],
            name: Some(output.clone()),
            op_type: Some(op.into()),
            attribute: attributes.to_vec(),
            domain: None,
        });
        output
    }

    /// Gives the last operation's output another name.
    pub(crate) fn named(&mut self, name: &str) -> String {
        if let Some(node) = self.graph.node.last_mut() {
            node.output = vec![name.into()];
        }
        name.into()
    }

    fn linear(&mut self, x: &str, prefix: &str, [inputs, outputs]: [usize; 2], arrays: &Arrays) -> String {
        let weight = self.floats(&format!("{prefix}.weight"), &[inputs, outputs], &arrays.weight);
        let bias = self.floats(&format!("{prefix}.bias"), &[outputs], &arrays.bias);
        self.node("Gemm", &[x, &weight, &bias], &[])
    }

    /// Linear layers with ELU between them.
    fn mlp(
        &mut self,
        x: &str,
        file: &Checkpoint,
        prefix: &str,
        widths: &[usize],
        columns: Option<&[usize]>,
    ) -> Result<String, RobotError> {
        let mut x = x.to_string();
        for (i, pair) in widths.windows(2).enumerate() {
            if i > 0 {
                x = self.node("Elu", &[&x], &[]);
            }
            let name = format!("{prefix}.layers.{i}");
            let mut arrays = Arrays::load(file, &name, &[pair[0], pair[1]], pair[1])?;
            if let Some(columns) = columns.filter(|_| i + 2 == widths.len()) {
                arrays.columns(columns);
            }
            x = self.linear(&x, &name, [pair[0], pair[1]], &arrays);
        }
        Ok(x)
    }
}

/// Weights of a layer.
struct Arrays {
    weight: Vec<f32>,
    bias: Vec<f32>,
}

impl Arrays {
    fn load(file: &Checkpoint, name: &str, shape: &[usize], outputs: usize) -> Result<Self, RobotError> {
        Ok(Self {
            weight: file.f32s(&format!("{name}.weight"), shape)?,
            bias: file.f32s(&format!("{name}.bias"), &[outputs])?,
        })
    }

    /// Takes the outputs in another order.
    fn columns(&mut self, order: &[usize]) {
        self.weight =
            self.weight.chunks_exact(order.len()).flat_map(|row| order.iter().map(|column| row[*column])).collect();
        self.bias = order.iter().map(|column| self.bias[*column]).collect();
    }
}

/// A whole-number setting.
pub(crate) fn whole(name: &str, value: i64) -> Attribute {
    Attribute { name: Some(name.into()), i: Some(value), kind: Some(2), ..Attribute::default() }
}

/// A setting of several whole numbers.
fn wholes(name: &str, values: &[i64]) -> Attribute {
    Attribute { name: Some(name.into()), ints: values.to_vec(), kind: Some(7), ..Attribute::default() }
}

fn number(name: &str, value: f32) -> Attribute {
    Attribute { name: Some(name.into()), f: Some(value), kind: Some(1), ..Attribute::default() }
}

/// Orders of the numbers in a file, where they are another stack's. Each says which number of ours stands at a place.
#[derive(Debug, Clone)]
pub(crate) struct Orders {
    /// Numbers of the observation.
    pub(crate) inputs: Vec<usize>,
    /// Joints.
    pub(crate) joints: Vec<usize>,
}

/// Adds the frozen policy: from the observation's numbers to the actions, clamped as the controller does it.
///
/// # Errors
/// An array is missing.
pub(crate) fn policy(
    builder: &mut Builder,
    file: &Checkpoint,
    header: &ControllerHeader,
    orders: Option<&Orders>,
    limits: &[(f32, f32)],
) -> Result<String, RobotError> {
    let spec = &header.observation;
    let (size, window, joints) = (spec.size(), spec.window_size(), spec.joints.len());
    let (mean, variance) = (file.f64s("normalizer.mean", &[size])?, file.f64s("normalizer.variance", &[size])?);
    let settings = file.f64s("normalizer.settings", &[4])?;
    let place = |i: usize| orders.map_or(i, |orders| orders.inputs[i]);
    let means: Vec<f32> = (0..size).map(|i| mean[place(i)] as f32).collect();
    let inverse = |v: f64| if v > 1e-8 { (1.0 / v.sqrt()) as f32 } else { 1.0 };
    let inverses: Vec<f32> = (0..size).map(|i| inverse(variance[place(i)])).collect();

    let mean = builder.floats("normalizer.mean", &[1, size], &means);
    let mut x = builder.node("Sub", &["obs", &mean], &[]);
    let inverse = builder.floats("normalizer.inverse_deviation", &[1, size], &inverses);
    x = builder.node("Mul", &[&x, &inverse], &[]);
    let clip = settings[2] as f32;
    if clip.is_finite() && clip >= 0.0 {
        let (low, high) = (builder.floats("clip.low", &[], &[-clip]), builder.floats("clip.high", &[], &[clip]));
        x = builder.node("Clip", &[&x, &low, &high], &[]);
    }
    // One order for the network's rows: ours.
    if let Some(Orders { inputs, .. }) = orders {
        let mut back = vec![0_i64; size];
        inputs.iter().enumerate().for_each(|(place, ours)| back[*ours] = place as i64);
        let order = builder.whole("order.inputs", &[size], &back);
        x = builder.node("Gather", &[&x, &order], &[whole("axis", 1)]);
    }
    let mut width = size;
    if let Some((hidden, code)) = &header.encoder {
        let own = size - window;
        let part = |builder: &mut Builder, x: &str, name: &str, from: usize, to: usize| {
            let range: Vec<i64> = (from..to).map(|i| i as i64).collect();
            let range = builder.whole(name, &[range.len()], &range);
            builder.node("Gather", &[x, &range], &[whole("axis", 1)])
        };
        let windows = part(builder, &x, "range.window", own, size);
        let rest = part(builder, &x, "range.own", 0, own);
        let widths: Vec<usize> = [window].into_iter().chain(hidden.iter().copied()).chain([*code]).collect();
        let codes = builder.mlp(&windows, file, "actor.encoder", &widths, None)?;
        let axis = builder.whole("axis.code", &[1], &[1]);
        let length = builder.node("ReduceL2", &[&codes, &axis], &[whole("keepdims", 1)]);
        let least = builder.floats("length.least", &[], &[1e-6]);
        let length = builder.node("Max", &[&length, &least], &[]);
        let codes = builder.node("Div", &[&codes, &length], &[]);
        x = builder.node("Concat", &[&rest, &codes], &[whole("axis", 1)]);
        width = own + code;
    }
    if let Some(state) = header.memory {
        let history = spec.history_size();
        let codes = memory(builder, &x, file, [size - history, size], (spec.reference.history, state))?;
        let own: Vec<i64> = (0..size - history).map(|i| i as i64).collect();
        let own = builder.whole("range.own", &[own.len()], &own);
        let rest = builder.node("Gather", &[&x, &own], &[whole("axis", 1)]);
        x = builder.node("Concat", &[&rest, &codes], &[whole("axis", 1)]);
        width = size - history + state;
    }
    let columns = orders.map(|orders| &orders.joints[..]);
    x = if header.layers.is_empty() {
        let widths: Vec<usize> = [width].into_iter().chain(header.hidden.iter().copied()).chain([joints]).collect();
        builder.mlp(&x, file, "actor.mean", &widths, columns)?
    } else {
        stack(builder, &x, file, &header.layers, width, columns)?
    };
    let Some(bounds) = bounds(header, limits) else { return Ok(x) };
    let ordered = |of: fn(&(f32, f32)) -> f32| -> Vec<f32> {
        (0..joints).map(|j| of(&bounds[columns.map_or(j, |columns| columns[j])])).collect()
    };
    let low = builder.floats("action.low", &[1, joints], &ordered(|bound| bound.0));
    let high = builder.floats("action.high", &[1, joints], &ordered(|bound| bound.1));
    let above = builder.node("Max", &[&x, &low], &[]);
    Ok(builder.node("Min", &[&above, &high], &[]))
}

/// Returns the actions within which the controller's targets are within their limits (rad); none where nothing is clamped.
pub(crate) fn bounds(header: &ControllerHeader, limits: &[(f32, f32)]) -> Option<Vec<(f32, f32)>> {
    let (most, scale) = (ActionSpec::OUTPUT_LIMIT as f32, header.action.scale() as f32);
    match header.action {
        ActionSpec::Unclamped { .. } => None,
        ActionSpec::Reference { .. } => Some(vec![(-most, most); limits.len()]),
        ActionSpec::Absolute => Some(limits.iter().map(|(low, high)| (low.max(-most), high.min(most))).collect()),
        ActionSpec::DefaultPose { .. } => {
            let within = |((low, high), pose): (&(f32, f32), &f32)| {
                (((low - pose) / scale).max(-most), ((high - pose) / scale).min(most))
            };
            Some(limits.iter().zip(&header.observation.default_pose).map(within).collect())
        }
    }
}

/// The last state of the recurrent unit that reads these numbers of a row: ONNX's `GRU`, whose gates come as z, r, n.
fn memory(
    builder: &mut Builder,
    x: &str,
    file: &Checkpoint,
    [from, to]: [usize; 2],
    (steps, state): (usize, usize),
) -> Result<String, RobotError> {
    let inputs = (to - from) / steps;
    let gates = 3 * state;
    let column = |gate: usize| [state, 0, 2 * state][gate / state] + gate % state;
    let (mut biases, mut maps) = (Vec::new(), Vec::new());
    for (name, rows) in [("input", inputs), ("state", state)] {
        let weight = file.f32s(&format!("actor.memory.{name}.layers.0.weight"), &[rows, gates])?;
        let bias = file.f32s(&format!("actor.memory.{name}.layers.0.bias"), &[gates])?;
        let turned: Vec<f32> = (0..gates)
            .flat_map(|gate| (0..rows).map(move |row| row * gates + column(gate)))
            .map(|at| weight[at])
            .collect();
        biases.extend((0..gates).map(|gate| bias[column(gate)]));
        maps.push(builder.floats(&format!("actor.memory.{name}"), &[1, gates, rows], &turned));
    }
    let biases = builder.floats("actor.memory.bias", &[1, 2 * gates], &biases);
    let range: Vec<i64> = (from..to).map(|i| i as i64).collect();
    let range = builder.whole("range.history", &[range.len()], &range);
    let rows = builder.node("Gather", &[x, &range], &[whole("axis", 1)]);
    let shape = builder.whole("shape.history", &[3], &[-1, steps as i64, inputs as i64]);
    let rows = builder.node("Reshape", &[&rows, &shape], &[]);
    let rows = builder.node("Transpose", &[&rows], &[wholes("perm", &[1, 0, 2])]);
    let settings = [whole("hidden_size", state as i64), whole("linear_before_reset", 1)];
    let states = builder.node("GRU", &[&rows, &maps[0], &maps[1], &biases], &settings);
    let last = builder.whole("step.last", &[], &[steps as i64 - 1]);
    let last = builder.node("Gather", &[&states, &last], &[whole("axis", 0)]);
    let axis = builder.whole("axis.direction", &[1], &[0]);
    Ok(builder.node("Squeeze", &[&last, &axis], &[]))
}

/// Layers of a network that was not trained here.
fn stack(
    builder: &mut Builder,
    x: &str,
    file: &Checkpoint,
    layers: &[Layer],
    mut width: usize,
    columns: Option<&[usize]>,
) -> Result<String, RobotError> {
    let mut x = x.to_string();
    for (i, layer) in layers.iter().enumerate() {
        let name = format!("actor.mean.layers.{i}");
        x = match *layer {
            Layer::Linear { outputs } => {
                let arrays = Arrays::load(file, &name, &[width, outputs], outputs)?;
                let sizes = [width, outputs];
                width = outputs;
                builder.linear(&x, &name, sizes, &arrays)
            }
            Layer::Affine | Layer::LayerNorm { .. } => {
                let arrays = Arrays::load(file, &name, &[width], width)?;
                let weight = builder.floats(&format!("{name}.weight"), &[width], &arrays.weight);
                let bias = builder.floats(&format!("{name}.bias"), &[width], &arrays.bias);
                if let Layer::LayerNorm { epsilon } = *layer {
                    builder.node("LayerNormalization", &[&x, &weight, &bias], &[number("epsilon", epsilon)])
                } else {
                    let x = builder.node("Mul", &[&x, &weight], &[]);
                    builder.node("Add", &[&x, &bias], &[])
                }
            }
            Layer::Elu => builder.node("Elu", &[&x], &[]),
            Layer::Relu => builder.node("Relu", &[&x], &[]),
            Layer::Tanh => builder.node("Tanh", &[&x], &[]),
            Layer::Silu => {
                let share = builder.node("Sigmoid", &[&x], &[]);
                builder.node("Mul", &[&x, &share], &[])
            }
        };
    }
    let Some(columns) = columns else { return Ok(x) };
    let order: Vec<i64> = columns.iter().map(|column| *column as i64).collect();
    let order = builder.whole("order.joints", &[order.len()], &order);
    Ok(builder.node("Gather", &[&x, &order], &[whole("axis", 1)]))
}
