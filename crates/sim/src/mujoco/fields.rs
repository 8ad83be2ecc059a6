//! The layout of MuJoCo's structs: names, types, rows and offsets. Written by fields.py.

use super::native::*;

arrays! { Model;
    qpos0: f64, nq, 1792; qpos_spring: f64, nq, 1800; body_parentid: i32, nbody, 1808; body_rootid: i32, nbody, 1816;
    body_weldid: i32, nbody, 1824; body_pos: [f64; 3], nbody, 1912; body_quat: [f64; 4], nbody, 1920;
    body_ipos: [f64; 3], nbody, 1928; body_iquat: [f64; 4], nbody, 1936; body_mass: f64, nbody, 1944;
    body_subtreemass: f64, nbody, 1952; body_inertia: [f64; 3], nbody, 1960; body_invweight0: [f64; 2], nbody, 1968;
    body_gravcomp: f64, nbody, 1976; jnt_type: i32, njnt, 2104; jnt_qposadr: i32, njnt, 2112;
    jnt_dofadr: i32, njnt, 2120; jnt_pos: [f64; 3], njnt, 2192; jnt_axis: [f64; 3], njnt, 2200;
    jnt_stiffness: f64, njnt, 2208; jnt_limited: bool, njnt, 2152; jnt_range: [f64; 2], njnt, 2224;
    jnt_actfrcrange: [f64; 2], njnt, 2232; dof_bodyid: i32, nv, 2256; dof_armature: f64, nv, 2328;
    dof_damping: f64, nv, 2336; dof_frictionloss: f64, nv, 2320; dof_invweight0: f64, nv, 2352; dof_m0: f64, nv, 2360;
    geom_type: i32, ngeom, 2416; geom_contype: i32, ngeom, 2424; geom_conaffinity: i32, ngeom, 2432;
    geom_condim: i32, ngeom, 2440; geom_bodyid: i32, ngeom, 2448; geom_dataid: i32, ngeom, 2456;
    geom_priority: i32, ngeom, 2480; geom_size: [f64; 3], ngeom, 2528; geom_pos: [f64; 3], ngeom, 2552;
    geom_quat: [f64; 4], ngeom, 2560; geom_friction: [f64; 3], ngeom, 2568; geom_margin: f64, ngeom, 2576;
    geom_gap: f64, ngeom, 2584; geom_solref: [f64; 2], ngeom, 2512; geom_solimp: [f64; 5], ngeom, 2520;
    site_bodyid: i32, nsite, 2640; site_pos: [f64; 3], nsite, 2688; site_quat: [f64; 4], nsite, 2696;
    eq_type: i32, neq, 4408; eq_obj1id: i32, neq, 4416; eq_obj2id: i32, neq, 4424; eq_objtype: i32, neq, 4432;
    eq_active0: bool, neq, 4440; eq_solref: [f64; 2], neq, 4448; eq_solimp: [f64; 5], neq, 4456;
    eq_data: [f64; 12], neq, 4464; tendon_invweight0: f64, ntendon, 4696;
}

values! { Model;
    nq: i64, 0; nv: i64, 8; nbody: i64, 48; njnt: i64, 88; ngeom: i64, 136; nsite: i64, 144; neq: i64, 472;
    ntendon: i64, 480; opt_timestep: f64, 792; opt_gravity: [f64; 3], 848; opt_integrator: i32, 1040;
    opt_disableflags: i32, 1072; opt_enableflags: i32, 1076; stat_meaninertia: f64, 1728; stat_meanmass: f64, 1736;
}

arrays_mut! { ModelMut<'_>;
    body_ipos_mut: [f64; 3], nbody, 1928; body_mass_mut: f64, nbody, 1944; body_subtreemass_mut: f64, nbody, 1952;
    body_inertia_mut: [f64; 3], nbody, 1960; body_invweight0_mut: [f64; 2], nbody, 1968;
    dof_armature_mut: f64, nv, 2328; dof_damping_mut: f64, nv, 2336; dof_frictionloss_mut: f64, nv, 2320;
    dof_invweight0_mut: f64, nv, 2352; dof_m0_mut: f64, nv, 2360; geom_contype_mut: i32, ngeom, 2424;
    geom_conaffinity_mut: i32, ngeom, 2432; geom_friction_mut: [f64; 3], ngeom, 2568;
    tendon_invweight0_mut: f64, ntendon, 4696;
}

values_mut! { ModelMut<'_>;
    opt_timestep_mut: f64, 792; opt_gravity_mut: [f64; 3], 848; opt_integrator_mut: i32, 1040;
    opt_disableflags_mut: i32, 1072; opt_enableflags_mut: i32, 1076; stat_meaninertia_mut: f64, 1728;
    stat_meanmass_mut: f64, 1736;
}

arrays! { Data;
    qpos: f64, nq, 160688; qvel: f64, nv, 160696; qacc_warmstart: f64, nv, 160720; qfrc_applied: f64, nv, 160744;
    xfrc_applied: [f64; 6], nbody, 160752; qacc: f64, nv, 160784; xpos: [f64; 3], nbody, 160840;
    xquat: [f64; 4], nbody, 160848; xipos: [f64; 3], nbody, 160864; subtree_com: [f64; 3], nbody, 160960;
    cdof: [f64; 6], nv, 160968; qfrc_bias: f64, nv, 161296; qfrc_passive: f64, nv, 161344;
    subtree_linvel: [f64; 3], nbody, 161352; subtree_angmom: [f64; 3], nbody, 161360; qfrc_smooth: f64, nv, 161416;
    qacc_smooth: f64, nv, 161424; qfrc_constraint: f64, nv, 161432; cfrc_int: [f64; 6], nbody, 161456;
    cfrc_ext: [f64; 6], nbody, 161464; contact: Contact, ncon, 161472; efc_type: i32, nefc, 161480;
    efc_id: i32, nefc, 161488; efc_j_rowadr: i32, nefc, 161504; efc_j: f64, nj, 161528; efc_force: f64, nefc, 162080;
}

values! { Data;
    ncon: i32, 160560; nefc: i32, 160576; nj: i32, 160580; time: f64, 160648; energy: [f64; 2], 160656;
}

arrays_mut! { Data;
    qpos_mut: f64, nq, 160688; qvel_mut: f64, nv, 160696; qacc_warmstart_mut: f64, nv, 160720;
    qfrc_applied_mut: f64, nv, 160744; xfrc_applied_mut: [f64; 6], nbody, 160752;
}

values_mut! { Data;
    time_mut: f64, 160648;
}

values_mut! { Geom<'_>;
    type_mut: i32, 8; pos_mut: [f64; 3], 16; size_mut: [f64; 3], 256; contype_mut: i32, 280;
    conaffinity_mut: i32, 284; condim_mut: i32, 288; priority_mut: i32, 292; friction_mut: [f64; 3], 296;
    solref_mut: [f64; 2], 328; solimp_mut: [f64; 5], 344; margin_mut: f64, 384; gap_mut: f64, 392;
}

constants! {
    VERSION_HEADER: i32, 3017000; OBJ_BODY: i32, 1; OBJ_JOINT: i32, 3; OBJ_GEOM: i32, 5; OBJ_SITE: i32, 6;
    GEOM_PLANE: i32, 0; GEOM_HFIELD: i32, 1; INT_EULER: i32, 0; INT_RK4: i32, 1; DSBL_SPRING: i32, 32;
    DSBL_DAMPER: i32, 64; DSBL_ACTUATION: i32, 2048; DSBL_SENSOR: i32, 8192; DSBL_EULERDAMP: i32, 32768;
    DSBL_AUTORESET: i32, 65536; ENBL_ENERGY: i32, 2; CNSTR_EQUALITY: i32, 0; CNSTR_FRICTION_DOF: i32, 1;
    CNSTR_LIMIT_JOINT: i32, 3; EQ_WELD: i32, 1; EQ_JOINT: i32, 2; SAMEFRAME_NONE: i32, 0; LOG_WARNING: i32, 2;
    LOG_ERROR: i32, 3;
}

offsets! {
    MODEL_BODY_SIMPLE: usize, 1896; MODEL_BODY_SAMEFRAME: usize, 1904; MODEL_DOF_SIMPLENUM: usize, 2296;
    MODEL_GEOM_SAMEFRAME: usize, 2496; MODEL_SITE_SAMEFRAME: usize, 2672; JOINT_ARMATURE: usize, 240;
    JOINT_STIFFNESS: usize, 80; JOINT_DAMPING: usize, 248; JOINT_SPRINGDAMPER: usize, 112; GEOM_ELEMENT: usize, 0;
    GEOM_HFIELDNAME: usize, 560; HFIELD_ELEMENT: usize, 0; HFIELD_SIZE: usize, 24; HFIELD_NROW: usize, 56;
    HFIELD_NCOL: usize, 60; HFIELD_USERDATA: usize, 64; CONTACT_DIST: usize, 0; CONTACT_FRAME: usize, 32;
    CONTACT_GEOM: usize, 540; CONTACT_EFC_ADDRESS: usize, 576; LOGMESSAGE_LEVEL: usize, 0;
    LOGMESSAGE_SUBJECT: usize, 8; CONTACT_SIZE: usize, 584;
}
