//! MuJoCo's models, data and specs, owned. Fields and constants have MuJoCo's names in lower case.
//!
//! A model in use can be edited through [`ModelMut`] only, so it cannot be exchanged for one of other sizes.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::marker::PhantomData;
use std::ops::Deref;
use std::ptr::{NonNull, null, null_mut};

pub use super::fields::*;
use super::library::{Library, library};

macro_rules! arrays {
    ($owner:ty; $($name:ident: $kind:ty, $rows:ident, $at:literal;)+) => { impl $owner { $(
        #[doc = concat!("MuJoCo's `", stringify!($name), "`.")]
        pub fn $name(&self) -> &[$kind] {
            // SAFETY: the table has the field's offset, type and number of rows.
            unsafe { array(self.base(), $at, self.$rows() as usize) }
        }
    )+ } };
}

macro_rules! arrays_mut {
    ($owner:ty; $($name:ident: $kind:ty, $rows:ident, $at:literal;)+) => { impl $owner { $(
        #[doc = concat!("Gives access to MuJoCo's field: `", stringify!($name), "`.")]
        pub fn $name(&mut self) -> &mut [$kind] {
            // SAFETY: the table has the field's offset, type and number of rows.
            unsafe { array_mut(self.base(), $at, self.$rows() as usize) }
        }
    )+ } };
}

macro_rules! values {
    ($owner:ty; $($name:ident: $kind:ty, $at:literal;)+) => { impl $owner { $(
        #[doc = concat!("MuJoCo's `", stringify!($name), "`.")]
        pub fn $name(&self) -> $kind {
            // SAFETY: the table has the field's offset and type.
            unsafe { self.base().add($at).cast::<$kind>().read() }
        }
    )+ } };
}

macro_rules! values_mut {
    ($owner:ty; $($name:ident: $kind:ty, $at:literal;)+) => { impl $owner { $(
        #[doc = concat!("Gives access to MuJoCo's field: `", stringify!($name), "`.")]
        pub fn $name(&mut self) -> &mut $kind {
            // SAFETY: the table has the field's offset and type.
            unsafe { &mut *self.base().add($at).cast::<$kind>() }
        }
    )+ } };
}

macro_rules! constants {
    ($($name:ident: $kind:ty, $value:literal;)+) => { $(
        #[doc = concat!("MuJoCo's `mj", stringify!($name), "`.")]
        pub const $name: $kind = $value;
    )+ };
}

macro_rules! offsets {
    ($($name:ident: $kind:ty, $value:literal;)+) => { $(pub(super) const $name: $kind = $value;)+ };
}

pub(super) use {arrays, arrays_mut, constants, offsets, values, values_mut};

/// The array of a pointer at an offset; empty where MuJoCo has none.
///
/// # Safety
/// At the offset is a pointer to `rows` rows, or null.
pub(super) unsafe fn array<'a, T>(base: *const u8, at: usize, rows: usize) -> &'a [T] {
    // SAFETY: the caller's.
    unsafe {
        let pointer = base.add(at).cast::<*const T>().read();
        if pointer.is_null() { &[] } else { std::slice::from_raw_parts(pointer, rows) }
    }
}

/// The same to be written.
///
/// # Safety
/// As of [`array`], and nobody else has the rows.
pub(super) unsafe fn array_mut<'a, T>(base: *mut u8, at: usize, rows: usize) -> &'a mut [T] {
    // SAFETY: the caller's.
    unsafe {
        let pointer = base.add(at).cast::<*mut T>().read();
        if pointer.is_null() { &mut [] } else { std::slice::from_raw_parts_mut(pointer, rows) }
    }
}

/// `mjContact` as far as it is used.
#[repr(C)]
#[derive(Debug)]
pub struct Contact {
    /// Distance between the nearest points (m).
    pub dist: f64,
    pos: [f64; 3],
    /// Axes; the first is the normal.
    pub frame: [f64; 9],
    solver: [f64; 53],
    dim: [c_int; 3],
    /// The geoms; -1 for none.
    pub geom: [c_int; 2],
    others: [c_int; 7],
    /// First row in `efc_*`; -1 for none.
    pub efc_address: c_int,
}

const _: () = assert!(
    std::mem::size_of::<Contact>() == CONTACT_SIZE
        && std::mem::offset_of!(Contact, dist) == CONTACT_DIST
        && std::mem::offset_of!(Contact, frame) == CONTACT_FRAME
        && std::mem::offset_of!(Contact, geom) == CONTACT_GEOM
        && std::mem::offset_of!(Contact, efc_address) == CONTACT_EFC_ADDRESS
);

/// A `mjSpec`: a model that can be edited before it is compiled.
#[derive(Debug)]
pub struct Spec {
    library: &'static Library,
    raw: NonNull<c_void>,
}

/// A geom of a spec.
#[derive(Debug)]
pub struct Geom<'a>(NonNull<u8>, PhantomData<&'a mut Spec>, &'static Library);

/// Writes a number at an offset.
///
/// # Safety
/// The struct has such a number there.
unsafe fn put<T>(base: *mut u8, at: usize, value: T) {
    // SAFETY: the caller's.
    unsafe { base.add(at).cast::<T>().write(value) }
}

impl Spec {
    /// Reads MJCF or URDF text.
    ///
    /// # Errors
    /// MuJoCo's message, or that there is no MuJoCo.
    pub fn from_xml_string(text: &str) -> Result<Self, String> {
        let library = library().map_err(|e| e.to_string())?;
        let text = CString::new(text).map_err(|_| "its text contains a zero byte")?;
        let mut message = [0 as c_char; 1000];
        // SAFETY: the text has a terminating zero; the message has this length, and MuJoCo terminates it.
        let raw =
            unsafe { (library.mj_parseXMLString)(text.as_ptr(), null(), message.as_mut_ptr(), message.len() as c_int) };
        // SAFETY: the message is terminated.
        let failed = || format!("parse failed: {}", unsafe { CStr::from_ptr(message.as_ptr()) }.to_string_lossy());
        NonNull::new(raw).map(|raw| Self { library, raw }).ok_or_else(failed)
    }

    /// Sets armature, stiffness and damping of a joint, where there is one of this name.
    pub fn set_joint(&mut self, name: &str, armature: f64, stiffness: f64, damping: f64) {
        let Ok(name) = CString::new(name) else { return };
        // SAFETY: the spec is whole, the name terminated; the offsets are those of a joint's numbers.
        unsafe {
            let element = (self.library.mjs_findElement)(self.raw.as_ptr(), OBJ_JOINT, name.as_ptr());
            if element.is_null() {
                return;
            }
            let joint = (self.library.mjs_asJoint)(element).cast();
            put(joint, JOINT_ARMATURE, armature);
            put(joint, JOINT_STIFFNESS, stiffness);
            put(joint, JOINT_DAMPING, damping);
            put(joint, JOINT_SPRINGDAMPER, [0.0_f64; 2]);
        }
    }

    /// Adds a geom to the world.
    ///
    /// # Errors
    /// That there is one of this name.
    pub fn add_geom(&mut self, name: &CStr) -> Result<Geom<'_>, String> {
        let library = self.library;
        // SAFETY: the spec is whole, and its world body always there.
        let geom = unsafe {
            let world = (library.mjs_findBody)(self.raw.as_ptr(), c"world".as_ptr());
            (library.mjs_addGeom)(world, null())
        };
        let mut geom = Geom(NonNull::new(geom.cast()).ok_or("no geom")?, PhantomData, library);
        named(library, geom.base(), GEOM_ELEMENT, name)?;
        Ok(geom)
    }

    /// Adds a height field: rows, columns and the heights row by row; `size` is as in MJCF (m).
    ///
    /// # Errors
    /// That there is one of this name.
    pub fn add_hfield(
        &mut self,
        name: &CStr,
        shape: [usize; 2],
        size: [f64; 4],
        heights: &[f32],
    ) -> Result<(), String> {
        // SAFETY: the spec is whole; the offsets are those of the field's numbers, and of a vector of MuJoCo's, which copies so
        // many numbers.
        let field = unsafe {
            let field = (self.library.mjs_addHField)(self.raw.as_ptr()).cast();
            put(field, HFIELD_NROW, shape[0] as c_int);
            put(field, HFIELD_NCOL, shape[1] as c_int);
            put(field, HFIELD_SIZE, size);
            let vector = field.add(HFIELD_USERDATA).cast::<*mut c_void>().read();
            (self.library.mjs_setFloat)(vector, heights.as_ptr(), heights.len() as c_int);
            field
        };
        named(self.library, field, HFIELD_ELEMENT, name)
    }

    /// Compiles the model.
    ///
    /// # Errors
    /// MuJoCo's message.
    pub fn compile(&mut self) -> Result<Model, String> {
        // SAFETY: the spec is whole, and stays so where MuJoCo refuses it; its message is terminated.
        let (raw, message) = unsafe {
            let raw = (self.library.mj_compile)(self.raw.as_ptr(), null());
            (raw, CStr::from_ptr((self.library.mjs_getError)(self.raw.as_ptr())))
        };
        let failed = || format!("compilation failed: {}", message.to_string_lossy());
        NonNull::new(raw).map(|raw| Model { library: self.library, raw }).ok_or_else(failed)
    }
}

/// Names an element whose pointer is at an offset of what it describes.
fn named(library: &Library, base: *mut u8, element: usize, name: &CStr) -> Result<(), String> {
    // SAFETY: the offset is that of the element of a geom or height field that was just added.
    let failed = unsafe { (library.mjs_setName)(base.add(element).cast::<*mut c_void>().read(), name.as_ptr()) };
    if failed == 0 { Ok(()) } else { Err(format!("'{}' exists already", name.to_string_lossy())) }
}

impl Drop for Spec {
    fn drop(&mut self) {
        // SAFETY: nobody else has it.
        unsafe { (self.library.mj_deleteSpec)(self.raw.as_ptr()) }
    }
}

impl Geom<'_> {
    pub(super) fn base(&mut self) -> *mut u8 {
        self.0.as_ptr()
    }

    /// Sets the name of its height field.
    pub fn set_hfieldname(&mut self, name: &CStr) {
        // SAFETY: at the offset is a string of MuJoCo's, whose text it copies.
        unsafe {
            let text = self.base().add(GEOM_HFIELDNAME).cast::<*mut c_void>().read();
            (self.2.mjs_setString)(text, name.as_ptr());
        }
    }
}

/// A `mjModel`.
#[derive(Debug)]
pub struct Model {
    library: &'static Library,
    raw: NonNull<c_void>,
}

/// A model to be edited.
#[derive(Debug)]
pub struct ModelMut<'a>(&'a mut Model);

// SAFETY: MuJoCo's model belongs to no thread.
unsafe impl Send for Model {}

impl Model {
    /// Compiles MJCF or URDF text.
    ///
    /// # Errors
    /// As [`Spec::from_xml_string`] and [`Spec::compile`].
    pub fn from_xml_string(text: &str) -> Result<Self, String> {
        Spec::from_xml_string(text)?.compile()
    }

    /// Returns a copy.
    ///
    /// # Errors
    /// That there is no memory.
    pub fn copy(&self) -> Result<Self, String> {
        // SAFETY: the model is whole.
        let raw = unsafe { (self.library.mj_copyModel)(null_mut(), self.raw.as_ptr()) };
        NonNull::new(raw).map(|raw| Self { library: self.library, raw }).ok_or_else(|| "no memory for a model".into())
    }

    /// Gives access to numbers that MuJoCo lets change.
    pub fn edit(&mut self) -> ModelMut<'_> {
        ModelMut(self)
    }

    /// Returns the name of an object of a kind, `OBJ_*`.
    pub fn id_to_name(&self, kind: i32, id: usize) -> Option<&str> {
        // SAFETY: MuJoCo checks both numbers; names are terminated and live as long as the model.
        unsafe {
            let name = (self.library.mj_id2name)(self.raw.as_ptr(), kind, id as c_int);
            if name.is_null() { None } else { CStr::from_ptr(name).to_str().ok() }
        }
    }

    /// Returns true where the Jacobian of the constraints is sparse.
    pub fn is_sparse(&self) -> bool {
        // SAFETY: the model is whole.
        unsafe { (self.library.mj_isSparse)(self.raw.as_ptr()) == 1 }
    }

    pub(super) fn base(&self) -> *mut u8 {
        self.raw.as_ptr().cast()
    }
}

impl Drop for Model {
    fn drop(&mut self) {
        // SAFETY: nobody else has it.
        unsafe { (self.library.mj_deleteModel)(self.raw.as_ptr()) }
    }
}

impl Deref for ModelMut<'_> {
    type Target = Model;

    fn deref(&self) -> &Model {
        self.0
    }
}

impl ModelMut<'_> {
    /// Makes MuJoCo compute what it leaves out where frames coincide or bodies are simple.
    pub fn forbid_shortcuts(&mut self) {
        let (base, bodies, geoms, sites) = (self.base(), self.nbody(), self.ngeom(), self.nsite());
        // SAFETY: the offsets are those of arrays of these types and sizes. That no frame coincides and no body is
        // simple is true of every model: the flags only allow to leave work out.
        unsafe {
            for (at, rows) in
                [(MODEL_BODY_SAMEFRAME, bodies), (MODEL_GEOM_SAMEFRAME, geoms), (MODEL_SITE_SAMEFRAME, sites)]
            {
                array_mut::<u8>(base, at, rows as usize).fill(SAMEFRAME_NONE as u8);
            }
            array_mut::<u8>(base, MODEL_BODY_SIMPLE, bodies as usize).fill(0);
            array_mut::<c_int>(base, MODEL_DOF_SIMPLENUM, self.nv() as usize).fill(0);
        }
    }
}

/// A `mjData` with its model.
#[derive(Debug)]
pub struct Data {
    model: Model,
    raw: NonNull<c_void>,
}

// SAFETY: MuJoCo's data belongs to no thread.
unsafe impl Send for Data {}

macro_rules! stages {
    ($($(#[$doc:meta])* $name:ident: $function:ident;)+) => { impl Data { $(
        $(#[$doc])*
        pub fn $name(&mut self) {
            // SAFETY: the data is that of the model.
            unsafe { (self.model.library.$function)(self.model.raw.as_ptr(), self.raw.as_ptr()) }
        }
    )+ } };
}

stages! {
    /// `mj_resetData`.
    reset: mj_resetData;
    /// `mj_setConst`: computes what follows from changed numbers of the model.
    set_const: mj_setConst;
    /// `mj_step`.
    step: mj_step;
    /// `mj_forward`.
    forward: mj_forward;
    /// `mj_kinematics`.
    kinematics: mj_kinematics;
    /// `mj_comPos`.
    com_pos: mj_comPos;
    /// `mj_subtreeVel`.
    subtree_vel: mj_subtreeVel;
    /// `mj_rnePostConstraint`.
    rne_post_constraint: mj_rnePostConstraint;
}

impl Data {
    /// Data of a model, which it takes.
    ///
    /// # Errors
    /// That there is no memory.
    pub fn new(model: Model) -> Result<Self, String> {
        // SAFETY: the model is whole.
        let raw = unsafe { (model.library.mj_makeData)(model.raw.as_ptr()) };
        NonNull::new(raw).map(|raw| Self { model, raw }).ok_or_else(|| "no memory for MuJoCo's data".into())
    }

    /// The model.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// Gives access to numbers of the model that MuJoCo lets change.
    pub fn model_mut(&mut self) -> ModelMut<'_> {
        self.model.edit()
    }

    /// Returns `mj_contactForce` of a contact.
    pub fn contact_force(&self, contact: usize) -> [f64; 6] {
        let mut force = [0.0; 6];
        if contact < self.contact().len() {
            let (model, data) = (self.model.raw.as_ptr(), self.raw.as_ptr());
            // SAFETY: the data is that of the model, and has the contact.
            unsafe { (self.model.library.mj_contactForce)(model, data, contact as c_int, force.as_mut_ptr()) }
        }
        force
    }

    /// Returns `mj_jac`: the Jacobians `[3, nv]` of a point of a body's, linear and angular.
    pub fn jac(&self, point: &[f64; 3], body: usize) -> [Vec<f64>; 2] {
        let mut out = [0, 1].map(|_| vec![0.0; 3 * self.nv() as usize]);
        let (model, data) = (self.model.raw.as_ptr(), self.raw.as_ptr());
        let [linear, angular] = out.each_mut().map(|rows| rows.as_mut_ptr());
        assert!(body < self.nbody() as usize, "no body {body}");
        // SAFETY: the data is that of the model, which has the body; both arrays have these sizes.
        unsafe { (self.model.library.mj_jac)(model, data, linear, angular, point.as_ptr(), body as c_int) }
        out
    }

    /// Returns `mj_fullM`: the mass matrix `[nv, nv]`.
    pub fn full_m(&self) -> Vec<f64> {
        let mut out = vec![0.0; (self.nv() * self.nv()) as usize];
        // SAFETY: the data is that of the model; the matrix has this size.
        unsafe { (self.model.library.mj_fullM)(self.model.raw.as_ptr(), self.raw.as_ptr(), out.as_mut_ptr()) }
        out
    }

    pub(super) fn nq(&self) -> i64 {
        self.model.nq()
    }

    pub(super) fn nv(&self) -> i64 {
        self.model.nv()
    }

    pub(super) fn nbody(&self) -> i64 {
        self.model.nbody()
    }

    pub(super) fn base(&self) -> *mut u8 {
        self.raw.as_ptr().cast()
    }
}

impl Drop for Data {
    fn drop(&mut self) {
        // SAFETY: nobody else has it.
        unsafe { (self.model.library.mj_deleteData)(self.raw.as_ptr()) }
    }
}
