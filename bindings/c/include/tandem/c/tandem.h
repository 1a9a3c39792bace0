/* SPDX-License-Identifier: MIT */
/* Copyright (c) 2026 The Tandem authors */
#ifndef TANDEM_C_TANDEM_H
#define TANDEM_C_TANDEM_H

/**
 * @file
 * Tandem for languages that call C: worlds, bodies, shapes, joints, stepping, sharing over
 * transports of the caller's, whole sessions over sockets, and scenes from files.
 *
 * What begins with TANDEM_C_API is in the library tandem_c, with TANDEM_C_SESSION_API in
 * tandem_c_session, with TANDEM_C_FILES_API in tandem_c_files: a program links those that it calls.
 *
 * Units are m, kg, s, N, rad; quaternions are x, y, z, w, unit, body to world. Times of a session
 * are nanoseconds.
 *
 * Defs are filled by their `_init` function and then changed, so that what a program does not know
 * has its default; what has no such function is filled with zeros first. Enums and truth values are
 * of 32 bits. Handles are values that carry a generation: one of something that was removed is
 * an error and never something else.
 *
 * Errors: whatever can fail returns a tandem_result and writes field, value and rule to `error`,
 * which may be null. What failed has changed nothing. No function lets a C++ exception out. What
 * returns no result says 0 of a null object and of a handle that is stale.
 *
 * Threads: distinct objects may be used at the same time, one object by one thread at a time. A
 * world counts as one with its peer or session, its characters, cars and the like, and the file
 * that it is from; a network with all its transports and their peers as well.
 */

#include <stddef.h>
#include <stdint.h>

/* TANDEM_C_SHARED is for users of DLLs; the CMake targets and pkg-config files define it. The
 * others are defined where the library itself is built as a shared one. */
#if defined(_WIN32)
#define TANDEM_C_EXPORT __declspec(dllexport)
#if defined(TANDEM_C_SHARED)
#define TANDEM_C_IMPORT __declspec(dllimport)
#else
#define TANDEM_C_IMPORT
#endif
#elif defined(__GNUC__)
#define TANDEM_C_EXPORT __attribute__((visibility("default")))
#define TANDEM_C_IMPORT TANDEM_C_EXPORT
#else
#define TANDEM_C_EXPORT
#define TANDEM_C_IMPORT
#endif
#if defined(tandem_c_EXPORTS)
#define TANDEM_C_API TANDEM_C_EXPORT
#else
#define TANDEM_C_API TANDEM_C_IMPORT
#endif
#if defined(tandem_c_session_EXPORTS)
#define TANDEM_C_SESSION_API TANDEM_C_EXPORT
#else
#define TANDEM_C_SESSION_API TANDEM_C_IMPORT
#endif
#if defined(tandem_c_files_EXPORTS)
#define TANDEM_C_FILES_API TANDEM_C_EXPORT
#else
#define TANDEM_C_FILES_API TANDEM_C_IMPORT
#endif

/* What a caller gives need not be one of the listed: it is looked at, in C++ as well. */
#ifdef __cplusplus
#define TANDEM_C_ENUM : int32_t
#else
#define TANDEM_C_ENUM
#endif

#ifdef __cplusplus
extern "C" {
#endif

/** Changes with every change of this header that an older program would not survive. */
#define TANDEM_C_VERSION 2
/** TANDEM_C_VERSION of the library that runs. */
TANDEM_C_API uint32_t tandem_c_version(void);

typedef enum tandem_result TANDEM_C_ENUM {
  TANDEM_OK = 0,
  TANDEM_INVALID_ARGUMENT = 1, /**< see the error's text */
  TANDEM_OUT_OF_MEMORY = 2,
  TANDEM_TOO_SMALL = 3, /**< the caller's buffer; what it must hold was written */
  TANDEM_FAILED = 4     /**< anything else */
} tandem_result;

/** What went wrong, for a person. */
typedef struct tandem_error {
  tandem_result result;
  char text[256]; /**< ends with 0; cut where it is longer */
} tandem_error;

typedef struct tandem_vec3 {
  double x, y, z;
} tandem_vec3;

typedef struct tandem_quat {
  double x, y, z, w;
} tandem_quat;

typedef struct tandem_pose {
  tandem_vec3 position;
  tandem_quat orientation;
} tandem_pose;

typedef struct tandem_twist {
  tandem_vec3 linear;  /**< m/s, world */
  tandem_vec3 angular; /**< rad/s, world */
} tandem_twist;

typedef struct tandem_body {
  uint32_t index, generation;
} tandem_body;

typedef struct tandem_collider {
  uint32_t index, generation;
} tandem_collider;

typedef struct tandem_joint {
  uint32_t index, generation;
} tandem_joint;

/** Stands for the world where a joint or an event names a body. */
#ifdef __cplusplus
#define TANDEM_NO_BODY (tandem_body{0xffffffffu, 0})
#else
#define TANDEM_NO_BODY ((tandem_body){0xffffffffu, 0})
#endif

/* ---- worlds ---- */

/** Bodies, shapes, joints, and the solver that steps them. */
typedef struct tandem_world tandem_world;

typedef struct tandem_world_def {
  tandem_vec3 gravity; /**< m/s^2; (0, 0, -9.81) */
  int32_t substeps;    /**< of a step, 1 to 1000; 4 */
  int32_t threads;     /**< 1 to 64; 1. Any number gives the same bits. */
  double sleep_after;  /**< s; 0.5; 0 = never */
  int32_t events;      /**< not 0: contact events are collected; 0 */
} tandem_world_def;

typedef struct tandem_step_report {
  int32_t finite; /**< 0: a body became NaN or infinite and was put back */
  int32_t bodies;
  int32_t awake;
  int32_t targets; /**< bodies that remote states pulled */
} tandem_step_report;

TANDEM_C_API void tandem_world_def_init(tandem_world_def* def);
/** Null where it failed. */
TANDEM_C_API tandem_world* tandem_world_create(const tandem_world_def* def, tandem_error* error);
/** After its peer or session, queries, characters and whatever else is on it. Null: nothing
 * happens. */
TANDEM_C_API void tandem_world_destroy(tandem_world* world);
/** @param dt  s, 1e-5 to 1e6     @param report  may be null */
TANDEM_C_API tandem_result tandem_world_step(tandem_world* world, double dt,
                                             tandem_step_report* report, tandem_error* error);
TANDEM_C_API tandem_result tandem_world_set_gravity(tandem_world* world, tandem_vec3 gravity,
                                                    tandem_error* error);
/** Equal bits, equal hash. */
TANDEM_C_API uint64_t tandem_world_hash(const tandem_world* world);
/** Everything that the next step and its events depend on; not the footing and jump of a character.
 * @param size  in: bytes of `buffer`, out: needed */
TANDEM_C_API tandem_result tandem_world_snapshot(const tandem_world* world, void* buffer,
                                                 size_t* size, tandem_error* error);
/** Of a world that was built the same way. The bytes may be anybody's. */
TANDEM_C_API tandem_result tandem_world_restore(tandem_world* world, const void* bytes, size_t size,
                                                tandem_error* error);

/* ---- bodies ---- */

typedef enum tandem_body_type TANDEM_C_ENUM {
  TANDEM_STATIC = 0,
  TANDEM_KINEMATIC = 1, /**< moves with the twist that it was given */
  TANDEM_DYNAMIC = 2
} tandem_body_type;

typedef struct tandem_body_def {
  tandem_body_type type; /**< TANDEM_DYNAMIC */
  tandem_pose pose;      /**< of the centre of mass */
  tandem_twist twist;
  double mass;          /**< kg, > 0; 1 */
  double inertia[9];    /**< kg m^2, row by row, body frame, about the centre of mass; 0.4 I */
  double gravity_scale; /**< 1 */
  double linear_damping, angular_damping; /**< 1/s */
  int32_t bullet;    /**< not 0: never gets through anything, small and fast as it may be */
  int32_t can_sleep; /**< 1 */
} tandem_body_def;

typedef struct tandem_state {
  tandem_pose pose;
  tandem_twist twist;
} tandem_state;

TANDEM_C_API void tandem_body_def_init(tandem_body_def* def);
TANDEM_C_API tandem_result tandem_body_add(tandem_world* world, const tandem_body_def* def,
                                           tandem_body* body, tandem_error* error);
/** With its colliders and joints. */
TANDEM_C_API tandem_result tandem_body_remove(tandem_world* world, tandem_body body,
                                              tandem_error* error);
TANDEM_C_API int32_t tandem_body_exists(const tandem_world* world, tandem_body body);
TANDEM_C_API tandem_result tandem_body_state(const tandem_world* world, tandem_body body,
                                             tandem_state* state, tandem_error* error);
/** Of many at once. */
TANDEM_C_API tandem_result tandem_body_states(const tandem_world* world, const tandem_body* bodies,
                                              size_t count, tandem_state* states,
                                              tandem_error* error);
TANDEM_C_API int32_t tandem_body_awake(const tandem_world* world, tandem_body body);
TANDEM_C_API tandem_result tandem_body_set_pose(tandem_world* world, tandem_body body,
                                                const tandem_pose* pose, tandem_error* error);
TANDEM_C_API tandem_result tandem_body_set_twist(tandem_world* world, tandem_body body,
                                                 const tandem_twist* twist, tandem_error* error);
/** A kinematic body is there after the next step. */
TANDEM_C_API tandem_result tandem_body_move_to(tandem_world* world, tandem_body body,
                                               const tandem_pose* pose, tandem_error* error);
/** During the next step. @param point  m, world; null: the centre of mass */
TANDEM_C_API tandem_result tandem_body_apply_force(tandem_world* world, tandem_body body,
                                                   tandem_vec3 force, const tandem_vec3* point,
                                                   tandem_error* error);
TANDEM_C_API tandem_result tandem_body_apply_torque(tandem_world* world, tandem_body body,
                                                    tandem_vec3 torque, tandem_error* error);
/** At once, N s. @param point  m, world; null: the centre of mass */
TANDEM_C_API tandem_result tandem_body_apply_impulse(tandem_world* world, tandem_body body,
                                                     tandem_vec3 impulse, const tandem_vec3* point,
                                                     tandem_error* error);

/* ---- shapes ---- */

typedef enum tandem_shape_kind TANDEM_C_ENUM {
  TANDEM_SPHERE = 0,     /**< radius */
  TANDEM_BOX = 1,        /**< half_extents */
  TANDEM_CAPSULE = 2,    /**< radius, half_height without caps; along z */
  TANDEM_CYLINDER = 3,   /**< radius, half_height; along z */
  TANDEM_CONE = 4,       /**< radius, half_height; apex up z */
  TANDEM_HALF_SPACE = 5, /**< normal, offset: solid where normal . x <= offset */
  TANDEM_HULL = 6,       /**< points: the convex hull of them */
  TANDEM_MESH = 7,       /**< points, triangles; for bodies that do not move */
  TANDEM_HEIGHTS = 8     /**< columns, rows, spacing, heights; for bodies that do not move */
} tandem_shape_kind;

/** Arrays are read during the call that is given the shape, and not kept. */
typedef struct tandem_shape {
  tandem_shape_kind kind;
  double radius, half_height;
  tandem_vec3 half_extents;
  tandem_vec3 normal;
  double offset;
  const tandem_vec3* points;
  size_t point_count;
  const uint32_t* triangles; /**< three indices each, counter-clockwise seen from outside */
  size_t triangle_count;
  uint32_t columns, rows;
  double spacing_x, spacing_y;
  const double* heights; /**< row by row */
} tandem_shape;

typedef struct tandem_mass {
  double mass;                /**< kg */
  tandem_vec3 centre_of_mass; /**< m, frame of the shape */
  double inertia[9];          /**< kg m^2, about it, row by row */
} tandem_mass;

typedef struct tandem_collider_def {
  tandem_body body;
  tandem_shape shape;
  tandem_pose local;       /**< of the shape in the body's frame */
  double friction;         /**< 0.5 */
  double restitution;      /**< 0 to 1; 0 */
  uint32_t category, mask; /**< two meet where each one's category is in the other's mask; 1, all */
  int32_t group;           /**< equal and > 0: always meet, equal and < 0: never; 0 */
  int32_t sensor;          /**< not 0: makes no contacts, only events; 0 */
} tandem_collider_def;

TANDEM_C_API void tandem_shape_init(tandem_shape* shape, tandem_shape_kind kind);
/** @param density  kg/m^3, > 0 */
TANDEM_C_API tandem_result tandem_shape_mass(const tandem_shape* shape, double density,
                                             tandem_mass* mass, tandem_error* error);
TANDEM_C_API void tandem_collider_def_init(tandem_collider_def* def, tandem_shape_kind kind);
TANDEM_C_API tandem_result tandem_collider_add(tandem_world* world, const tandem_collider_def* def,
                                               tandem_collider* collider, tandem_error* error);
TANDEM_C_API tandem_result tandem_collider_remove(tandem_world* world, tandem_collider collider,
                                                  tandem_error* error);

/* ---- joints ---- */

typedef enum tandem_joint_kind TANDEM_C_ENUM {
  TANDEM_FIXED = 0,
  TANDEM_BALL = 1,
  TANDEM_HINGE = 2, /**< turns about the axis */
  TANDEM_SLIDER = 3 /**< moves along the axis */
} tandem_joint_kind;

typedef enum tandem_motor_mode TANDEM_C_ENUM {
  TANDEM_MOTOR_OFF = 0,
  TANDEM_MOTOR_VELOCITY = 1,
  TANDEM_MOTOR_POSITION = 2
} tandem_motor_mode;

/** Frames are laid as the bodies stand; all coordinates are 0 there. */
typedef struct tandem_joint_def {
  tandem_joint_kind kind;
  tandem_body a, b;   /**< a may be TANDEM_NO_BODY, the world */
  tandem_vec3 anchor; /**< m, world */
  tandem_vec3 axis;   /**< world; hinges and sliders; (1, 0, 0) */
  double compliance;  /**< m/N of what it locks, 0 = rigid; 0 */
  /* Of hinges (rad, N m) and sliders (m, N): */
  int32_t limited; /**< not 0: between lower and upper; 0 */
  double lower, upper;
  tandem_motor_mode motor;              /**< TANDEM_MOTOR_OFF */
  double motor_target, motor_max_force; /**< 0; infinite */
  double break_force, break_torque;     /**< N, N m; 0 = never */
} tandem_joint_def;

TANDEM_C_API void tandem_joint_def_init(tandem_joint_def* def, tandem_joint_kind kind);
TANDEM_C_API tandem_result tandem_joint_add(tandem_world* world, const tandem_joint_def* def,
                                            tandem_joint* joint, tandem_error* error);
TANDEM_C_API tandem_result tandem_joint_remove(tandem_world* world, tandem_joint joint,
                                               tandem_error* error);
/** Of a hinge or a slider. */
TANDEM_C_API tandem_result tandem_joint_set_motor(tandem_world* world, tandem_joint joint,
                                                  tandem_motor_mode mode, double target,
                                                  double max_force, tandem_error* error);
/** A motor as soft as a spring and a damper: stiffness (target - position) - damping speed
 * (TANDEM_MOTOR_POSITION), or damping (target - speed) (TANDEM_MOTOR_VELOCITY, whose stiffness is
 * 0), at most max_force. N/m and N s/m, or N m/rad and N m s/rad. */
TANDEM_C_API tandem_result tandem_joint_set_servo(tandem_world* world, tandem_joint joint,
                                                  tandem_motor_mode mode, double target,
                                                  double stiffness, double damping,
                                                  double max_force, tandem_error* error);
/** rad or m of a hinge or a slider, 0 of others. @param broken  may be null */
TANDEM_C_API tandem_result tandem_joint_position(const tandem_world* world, tandem_joint joint,
                                                 double* position, int32_t* broken,
                                                 tandem_error* error);

/* ---- characters, cars, ropes, cloth, ragdolls ---- */

/* Each is made of bodies of a world, which go with it as it is destroyed, and before its world.
 * Where the program removes one of its bodies by itself, nothing but that remains to be done with
 * it. A null one: nothing happens. Lists of bodies copy at most `capacity` and say how many there
 * are. */

/** As of a collider. */
typedef struct tandem_filter {
  uint32_t category, mask; /**< 1, all */
  int32_t group;           /**< 0: cars, ropes, cloth and ragdolls get one of their own */
} tandem_filter;

/** A capsule that walks, climbs steps and slopes, jumps, is carried, pushes and is pushed. */
typedef struct tandem_character tandem_character;

typedef struct tandem_character_def {
  double radius, half_height; /**< m, of the capsule, without caps; 0.3, 0.6 */
  tandem_vec3 position;       /**< m, world, of its middle; (0, 0, 1) */
  double mass;                /**< kg; 70 */
  double max_push;            /**< N, against what stands in its way; 400 */
  double max_slope;           /**< rad, 0 to 1.5: steeper ground is slid down; 0.87 */
  double max_step;            /**< m, up and down without leaving the ground; 0.35 */
  double air_acceleration;    /**< m/s^2, that the user has in the air; 10 */
  double padding;             /**< m, below the radius: gap that it keeps to everything; 0.02 */
  tandem_filter filter;
} tandem_character_def;

typedef enum tandem_footing TANDEM_C_ENUM {
  TANDEM_ON_GROUND = 0,
  TANDEM_ON_STEEP = 1, /**< slides down something steeper than max_slope */
  TANDEM_IN_AIR = 2
} tandem_footing;

typedef struct tandem_character_state {
  tandem_body body;
  tandem_footing footing;    /**< after the last tandem_character_walk */
  tandem_body ground;        /**< what it stands on or slides down; in the air TANDEM_NO_BODY */
  tandem_vec3 ground_normal; /**< unit, world; up in the air */
  tandem_vec3 velocity;      /**< m/s, world, what carries it included */
} tandem_character_state;

TANDEM_C_API void tandem_character_def_init(tandem_character_def* def);
TANDEM_C_API tandem_character* tandem_character_create(tandem_world* world,
                                                       const tandem_character_def* def,
                                                       tandem_error* error);
TANDEM_C_API void tandem_character_destroy(tandem_character* character);
/** Before each step. @param velocity  m/s, wanted, relative to the ground     @param dt  s, of it
 */
TANDEM_C_API tandem_result tandem_character_walk(tandem_character* character, tandem_vec3 velocity,
                                                 double dt, tandem_error* error);
/** The next walk leaves the ground, where it stands on some. @param speed  m/s, >= 0 */
TANDEM_C_API tandem_result tandem_character_jump(tandem_character* character, double speed,
                                                 tandem_error* error);
TANDEM_C_API tandem_result tandem_character_get_state(const tandem_character* character,
                                                      tandem_character_state* state,
                                                      tandem_error* error);

/** A chassis on four wheels with springs, all of them driven and braked, the two in front steered.
 */
typedef struct tandem_car tandem_car;

/** Its frame is that of the chassis: x forward, y left, z up. */
typedef struct tandem_car_def {
  tandem_pose pose;         /**< of the chassis; at (0, 0, 0.8) */
  tandem_vec3 half_extents; /**< m, of the chassis; (2, 0.8, 0.25) */
  double mass;              /**< kg, without wheels; 1200 */
  double wheelbase;         /**< m, between the axles; 2.6 */
  double track;             /**< m, between the wheels of an axle; 1.5 */
  double axle_height;       /**< m, of the axles in the frame, springs at ease; -0.4 */
  double wheel_radius;      /**< m; 0.35 */
  double wheel_width;       /**< m; 0.2 */
  double wheel_mass;        /**< kg; 20 */
  double stiffness;         /**< N/m, of each wheel's spring; 30e3 */
  double damping;           /**< N s/m; 3e3 */
  double travel;            /**< m, to either side of where springs are at ease; 0.25 */
  double friction;          /**< of tyres; 0.9 */
  double drive_torque;      /**< N m, of all four wheels; 1600 */
  double brake_torque;      /**< N m, likewise; 8000 */
  double top_speed;         /**< m/s: the wheels turn no faster; 40 */
  double max_steer;         /**< rad, 0 to 1.5; 0.6 */
  tandem_filter filter;
} tandem_car_def;

TANDEM_C_API void tandem_car_def_init(tandem_car_def* def);
TANDEM_C_API tandem_car* tandem_car_create(tandem_world* world, const tandem_car_def* def,
                                           tandem_error* error);
TANDEM_C_API void tandem_car_destroy(tandem_car* car);
/** Until it is called again.
 * @param throttle  -1, back, to 1
 * @param steer  rad, to the left, of a wheel between those in front
 * @param brake  0 to 1; above 0 nothing drives */
TANDEM_C_API tandem_result tandem_car_drive(tandem_car* car, double throttle, double steer,
                                            double brake, tandem_error* error);
/** Of the chassis, m/s, forward; 0 of a car whose chassis was removed. */
TANDEM_C_API double tandem_car_speed(const tandem_car* car);
/** The chassis, then the wheels: front left, front right, rear left, rear right. */
TANDEM_C_API size_t tandem_car_bodies(const tandem_car* car, tandem_body* bodies, size_t capacity);

/** What holds a particle of a rope or a cloth on a body. */
typedef struct tandem_attachment {
  uint64_t number; /**< never given again; 0: none */
} tandem_attachment;

/** The particle goes its way again, and still touches nothing. */
TANDEM_C_API tandem_result tandem_attachment_remove(tandem_world* world,
                                                    tandem_attachment attachment,
                                                    tandem_error* error);

/** A rope of point masses, each a body. */
typedef struct tandem_rope tandem_rope;

typedef struct tandem_rope_def {
  tandem_vec3 from, to;         /**< m, world; (0, 0, 0), (1, 0, 0) */
  double length;                /**< m, at least their distance, which it is where 0; 0 */
  int32_t particles;            /**< at least 2, ends included; an odd number where it hangs; 20 */
  double mass;                  /**< kg, of all of it; 0.5 */
  double radius;                /**< m: it touches others as balls of this size; 0.01 */
  double compliance;            /**< 1/N: strain for each newton; 0 */
  double bending;               /**< N m^2: moment for each curvature; 0 */
  double damping;               /**< 1/s, by the air; 0.1 */
  double friction, restitution; /**< 0.5, 0 */
  tandem_filter filter;
} tandem_rope_def;

TANDEM_C_API void tandem_rope_def_init(tandem_rope_def* def);
TANDEM_C_API tandem_rope* tandem_rope_create(tandem_world* world, const tandem_rope_def* def,
                                             tandem_error* error);
TANDEM_C_API void tandem_rope_destroy(tandem_rope* rope);
/** The particles, from one end to the other. */
TANDEM_C_API size_t tandem_rope_bodies(const tandem_rope* rope, tandem_body* bodies,
                                       size_t capacity);
/** Hold a particle where it now is on a body. It touches nothing from then on.
 * @param attachment  may be null */
TANDEM_C_API tandem_result tandem_rope_attach(tandem_rope* rope, uint32_t particle,
                                              tandem_body host, tandem_attachment* attachment,
                                              tandem_error* error);

/** A rectangle of cloth of point masses, each a body. */
typedef struct tandem_cloth tandem_cloth;

/** Its frame is that of a flat rectangle with a corner at the origin: columns along x, rows along
 * y. */
typedef struct tandem_cloth_def {
  tandem_pose pose;
  double width, height;         /**< m, along x and y; 1, 1 */
  int32_t columns, rows;        /**< particles along x and y, at least 2; 20, 20 */
  double density;               /**< kg/m^2; 0.2 */
  double radius;                /**< m: it touches others as balls of this size; 0.01 */
  double stretching;            /**< N/m, along the threads; 0: they do not stretch; 0 */
  double shearing;              /**< N/m, along the diagonals; 0: none; 50 */
  double bending;               /**< N m: moment on each metre of width for each curvature; 1e-4 */
  double damping;               /**< 1/s, by the air; 0.2 */
  double friction, restitution; /**< 0.5, 0 */
  tandem_filter filter;
} tandem_cloth_def;

TANDEM_C_API void tandem_cloth_def_init(tandem_cloth_def* def);
TANDEM_C_API tandem_cloth* tandem_cloth_create(tandem_world* world, const tandem_cloth_def* def,
                                               tandem_error* error);
TANDEM_C_API void tandem_cloth_destroy(tandem_cloth* cloth);
/** The particles, row by row. */
TANDEM_C_API size_t tandem_cloth_bodies(const tandem_cloth* cloth, tandem_body* bodies,
                                        size_t capacity);
/** As tandem_rope_attach. */
TANDEM_C_API tandem_result tandem_cloth_attach(tandem_cloth* cloth, int32_t column, int32_t row,
                                               tandem_body host, tandem_attachment* attachment,
                                               tandem_error* error);
/** Each particle keeps within its distance of the nearest one that is attached by now: what hangs
 * does not stretch. Once, after what is attached. */
TANDEM_C_API tandem_result tandem_cloth_tether(tandem_cloth* cloth, tandem_error* error);
/** A body at the mean of the cloth about a point, which can be held, pulled and shared.
 * @param u, v  0 to 1, along columns and rows
 * @param reach  m, above the distance of particles
 * @param share  above 0 and below 1: of the mass there, which goes from particles to the body */
TANDEM_C_API tandem_result tandem_cloth_add_handle(tandem_cloth* cloth, double u, double v,
                                                   double reach, double share, tandem_body* body,
                                                   tandem_error* error);

/** Somebody who has fainted: eleven bodies on ten joints with the limits of people's. */
typedef struct tandem_ragdoll tandem_ragdoll;

/** Its frame stands between the feet: x forward, y left, z up. */
typedef struct tandem_ragdoll_def {
  tandem_pose pose;
  double height;                /**< m; 1.75 */
  double mass;                  /**< kg, of all of it; 70 */
  double damping;               /**< N m s/rad, of each joint: how limp it is; 2 */
  double friction, restitution; /**< 0.5, 0 */
  tandem_filter filter;
} tandem_ragdoll_def;

TANDEM_C_API void tandem_ragdoll_def_init(tandem_ragdoll_def* def);
TANDEM_C_API tandem_ragdoll* tandem_ragdoll_create(tandem_world* world,
                                                   const tandem_ragdoll_def* def,
                                                   tandem_error* error);
TANDEM_C_API void tandem_ragdoll_destroy(tandem_ragdoll* ragdoll);
/** Pelvis, chest, head, left upper arm and forearm, right upper arm and forearm, left thigh and
 * shin, right thigh and shin. */
TANDEM_C_API size_t tandem_ragdoll_bodies(const tandem_ragdoll* ragdoll, tandem_body* bodies,
                                          size_t capacity);

/* ---- events of the last step, where the world collects them ---- */

typedef struct tandem_contact {
  tandem_collider collider_a, collider_b;
  tandem_body body_a, body_b;
} tandem_contact;

/** Faster than 1 m/s. */
typedef struct tandem_hit {
  tandem_contact contact;
  tandem_vec3 point;  /**< m, world */
  tandem_vec3 normal; /**< unit, world, from a to b */
  double speed;       /**< m/s, of approach */
  double impulse;     /**< N s */
} tandem_hit;

typedef enum tandem_contact_list TANDEM_C_ENUM {
  TANDEM_BEGUN = 0,
  TANDEM_ENDED = 1,
  TANDEM_TOUCHING = 2,
  TANDEM_SENSOR_BEGUN = 3, /**< a is the sensor */
  TANDEM_SENSOR_ENDED = 4,
  TANDEM_IN_SENSOR = 5
} tandem_contact_list;

/** Copies at most `capacity` of them. @return how many there are */
TANDEM_C_API size_t tandem_world_contacts(const tandem_world* world, tandem_contact_list list,
                                          tandem_contact* contacts, size_t capacity);
TANDEM_C_API size_t tandem_world_hits(const tandem_world* world, tandem_hit* hits, size_t capacity);

/* ---- queries ---- */

/** Rays, casts, overlaps and nearest places among the colliders of a world, as they were at the
 * last update. They change nothing: a world runs the same with and without them. */
typedef struct tandem_query tandem_query;

/** Not 0 where a query is to see this collider; called for candidates alone, in no special order.
 */
typedef int32_t (*tandem_accept)(void* user, tandem_collider collider);

/** Which colliders a query sees. A null pointer to it is the default. */
typedef struct tandem_query_filter {
  uint32_t category, mask; /**< as of a collider; all, all */
  int32_t group;           /**< likewise; 0 */
  tandem_body ignore;      /**< all colliders of that body are left out; TANDEM_NO_BODY */
  int32_t sensors;         /**< not 0: sensors too; 0 */
  int32_t back_faces;      /**< not 0: the backs of triangles stop rays and casts, too; 0 */
  tandem_accept accept;    /**< null: all */
  void* user;              /**< first argument of accept */
} tandem_query_filter;

typedef struct tandem_query_hit {
  tandem_collider collider;
  tandem_body body;
  tandem_vec3 point;  /**< m, world, on the collider */
  tandem_vec3 normal; /**< unit, world, out of the collider */
  double distance;    /**< m: along a ray; to the nearest place; below 0: overlap */
  double fraction;    /**< of a ray's or a cast's way, 0 to 1; else 0 */
  uint32_t triangle;  /**< of a mesh; else 0xffffffff */
} tandem_query_hit;

/** The world must outlive it. It sees the world as it is now. Null where it failed. */
TANDEM_C_API tandem_query* tandem_query_create(const tandem_world* world, tandem_error* error);
/** Null: nothing happens. */
TANDEM_C_API void tandem_query_destroy(tandem_query* query);
/** Bodies have moved, colliders have changed: see the world as it is now. */
TANDEM_C_API tandem_result tandem_query_update(tandem_query* query, tandem_error* error);
TANDEM_C_API void tandem_query_filter_init(tandem_query_filter* filter);

/* Hits come by distance, one for each collider. At most `capacity` of them are written to `hits`,
 * which may be null where it is 0; `count` says how many there are, where no more than one was
 * asked for only whether there is any. Shapes to ask with are convex. */

/** @param direction  of any length above 0     @param max_distance  m, > 0 */
TANDEM_C_API tandem_result tandem_query_ray(const tandem_query* query, tandem_vec3 origin,
                                            tandem_vec3 direction, double max_distance,
                                            const tandem_query_filter* filter,
                                            tandem_query_hit* hits, size_t capacity, size_t* count,
                                            tandem_error* error);
/** The shape moves from `start` by `displacement` (m) without turning. */
TANDEM_C_API tandem_result tandem_query_cast(const tandem_query* query, const tandem_shape* shape,
                                             const tandem_pose* start, tandem_vec3 displacement,
                                             const tandem_query_filter* filter,
                                             tandem_query_hit* hits, size_t capacity, size_t* count,
                                             tandem_error* error);
/** What is nearest, no further than `max_distance` (m, >= 0). @param shape  null: a point */
TANDEM_C_API tandem_result tandem_query_closest(const tandem_query* query,
                                                const tandem_shape* shape, const tandem_pose* pose,
                                                double max_distance,
                                                const tandem_query_filter* filter,
                                                tandem_query_hit* hits, size_t capacity,
                                                size_t* count, tandem_error* error);
/** What shares a point with the shape, in ascending order. */
TANDEM_C_API tandem_result tandem_query_overlap(const tandem_query* query,
                                                const tandem_shape* shape, const tandem_pose* pose,
                                                const tandem_query_filter* filter,
                                                tandem_collider* colliders, size_t capacity,
                                                size_t* count, tandem_error* error);

/* ---- transports ---- */

/** Carries bytes between peers. */
typedef struct tandem_transport tandem_transport;

typedef enum tandem_delivery TANDEM_C_ENUM {
  TANDEM_NEWEST = 0,  /**< may be lost */
  TANDEM_RELIABLE = 1 /**< in order, all of them */
} tandem_delivery;

/** Takes a packet; the bytes are copied. @param inbox  what the transport was given */
typedef void (*tandem_receive)(void* inbox, uint64_t from, const void* bytes, size_t size);
/** Takes a peer that there is or was. @param list  what the transport was given */
typedef void (*tandem_list_peer)(void* list, uint64_t peer, int32_t connected);

/** A transport of the caller's. The functions are called during tandem_peer_ and tandem_session_
 * functions alone, by their thread, and must not call back into the peer, the session or its world.
 */
typedef struct tandem_transport_def {
  void* user;    /**< first argument of all of them */
  uint64_t self; /**< this peer; unique in the session, never 0 */
  /** Not 0 where the bytes, max_packet of them at most, were taken. Must not wait. */
  int32_t (*post)(void* user, uint64_t to, const void* bytes, size_t size,
                  tandem_delivery delivery);
  /** Calls receive(inbox, ...) for each packet that has come since, as it was posted. */
  void (*drain)(void* user, tandem_receive receive, void* inbox);
  /** Calls list(into, ...) for each peer ever seen, by ascending id. */
  void (*peers)(void* user, tandem_list_peer list, void* into);
  /** Cut a peer off: what it sends cannot be understood. May be null. */
  void (*drop)(void* user, uint64_t peer, const char* reason);
  /** Bytes of the longest packet that post takes, reliable or not: 512 to 61440; 0 is 61440. What a
   * peer has to say is cut to it. */
  size_t max_packet;
} tandem_transport_def;

TANDEM_C_API tandem_transport* tandem_transport_create(const tandem_transport_def* def,
                                                       tandem_error* error);
/** After its peer or session. Null: nothing happens. */
TANDEM_C_API void tandem_transport_destroy(tandem_transport* transport);

/** A network between peers of one process, in virtual time: for tests. */
typedef struct tandem_network tandem_network;

typedef struct tandem_link {
  double latency, jitter; /**< s, one way */
  double loss;            /**< chance that a state is lost */
  double bandwidth;       /**< bit/s; 0 = unlimited */
} tandem_link;

TANDEM_C_API tandem_network* tandem_network_create(const tandem_link* link, uint64_t seed,
                                                   int64_t start_ns, tandem_error* error);
/** After all peers on it; with its transports. */
TANDEM_C_API void tandem_network_destroy(tandem_network* network);
/** Owned by the network. */
TANDEM_C_API tandem_transport* tandem_network_transport(tandem_network* network, uint64_t peer,
                                                        tandem_error* error);
/** Deliver what is due. @param time_ns  never goes back */
TANDEM_C_API tandem_result tandem_network_advance(tandem_network* network, int64_t time_ns,
                                                  tandem_error* error);

/* ---- messages of the application ---- */

/** Events between peers, by topic: each once, those of a sender in their order, through losses and
 * broken connections. All members of a session use one, or none sends any. */
typedef struct tandem_channel tandem_channel;

typedef struct tandem_event {
  uint64_t from;
  int64_t stamp_ns;    /**< session time at which it was sent */
  const char* topic;   /**< ends with 0, but may hold one before; untrusted, as the payload is */
  size_t topic_size;   /**< bytes */
  const void* payload; /**< valid until the next poll */
  size_t payload_size; /**< bytes */
} tandem_event;

/** The transport must outlive it. */
TANDEM_C_API tandem_channel* tandem_channel_create(tandem_transport* transport,
                                                   tandem_error* error);
/** After the peer on its transport. Null: nothing happens. */
TANDEM_C_API void tandem_channel_destroy(tandem_channel* channel);
/** What the peer is given in place of the transport; owned by the channel. Null of a null one. */
TANDEM_C_API tandem_transport* tandem_channel_transport(tandem_channel* channel);
/** Before each tandem_peer_before_step. */
TANDEM_C_API tandem_result tandem_channel_poll(tandem_channel* channel, int64_t now_ns,
                                               tandem_error* error);
/** With the time of the last poll. @param topic  64 bytes at most     @param to  0: all */
TANDEM_C_API tandem_result tandem_channel_send(tandem_channel* channel, const char* topic,
                                               const void* payload, size_t size, uint64_t to,
                                               tandem_error* error);
/** Copies at most `capacity` of those that the last poll took in. @return how many there are */
TANDEM_C_API size_t tandem_channel_events(const tandem_channel* channel, tandem_event* events,
                                          size_t capacity);

/* ---- sharing ---- */

/** One participant of a session: shares bodies of a world with those of the other peers. */
typedef struct tandem_peer tandem_peer;

typedef struct tandem_peer_def {
  double update_hz;      /**< states sent each second; 60 */
  double influence;      /**< share of a difference that is closed per 1/60 s; 0.08 */
  double authority_ramp; /**< s, over which a newcomer gets its say; 1 */
  int32_t compact;   /**< not 0: states are rounded (0.12 mm) and take about 27 bytes, not 93; 0 */
  double tolerance;  /**< m: what others expect more exactly is not sent; 0 = all is */
  double kbit_per_s; /**< to each of the others, at most; 0 = no limit */
  double replay_budget; /**< steps that may be replayed in each step to agree, at least 1; 4 */
} tandem_peer_def;

typedef struct tandem_shared_id {
  uint64_t high, low;
} tandem_shared_id;

typedef struct tandem_grab_def {
  tandem_shared_id body;
  tandem_vec3 attachment;               /**< m, frame of the body */
  tandem_vec3 anchor;                   /**< m, world: the hand */
  double stiffness, damping, max_force; /**< N/m, N s/m, N; 500, 20, 1e6 */
} tandem_grab_def;

/** What an application does to a shared body in one moment: what is not set stays, impulses are
 * added. */
typedef struct tandem_act_def {
  tandem_shared_id body;
  tandem_vec3 impulse;         /**< N s, world, at the centre of mass */
  tandem_vec3 angular_impulse; /**< N m s, world */
  int32_t sets_pose;           /**< not 0: to `pose`; 0 */
  int32_t sets_twist;          /**< not 0: to `twist`; 0 */
  tandem_pose pose;
  tandem_twist twist;
  uint64_t name; /**< acts of one name on a body are one within 1 s, whoever does them; 0 = none */
} tandem_act_def;

typedef struct tandem_peer_stats {
  uint64_t updates_received, packets_received, packets_rejected, bytes_sent, bodies_placed;
} tandem_peer_stats;

TANDEM_C_API void tandem_peer_def_init(tandem_peer_def* def);
TANDEM_C_API tandem_peer* tandem_peer_create(tandem_world* world, tandem_transport* transport,
                                             const tandem_peer_def* def, tandem_error* error);
/** Before its world and its transport. Null: nothing happens. */
TANDEM_C_API void tandem_peer_destroy(tandem_peer* peer);
/** The id that belongs to a name; the same on every machine. */
TANDEM_C_API tandem_shared_id tandem_shared_id_of(const char* name);
/** @param owner  the peer that alone moves it; 0 = nobody owns it */
TANDEM_C_API tandem_result tandem_peer_share(tandem_peer* peer, tandem_shared_id id,
                                             tandem_body body, uint64_t owner, tandem_error* error);
TANDEM_C_API tandem_result tandem_peer_unshare(tandem_peer* peer, tandem_shared_id id,
                                               tandem_error* error);
/* Each step: tandem_peer_before_step(now), tandem_world_step(dt), tandem_peer_after_step(now + dt),
 * with session times in ns, above 0. */
TANDEM_C_API tandem_result tandem_peer_before_step(tandem_peer* peer, int64_t now_ns,
                                                   tandem_error* error);
TANDEM_C_API tandem_result tandem_peer_after_step(tandem_peer* peer, int64_t now_ns,
                                                  tandem_error* error);
/** The other peers let go of this one's springs. */
TANDEM_C_API tandem_result tandem_peer_leave(tandem_peer* peer, int64_t now_ns,
                                             tandem_error* error);
TANDEM_C_API void tandem_grab_def_init(tandem_grab_def* def);
/** Hold a shared body with a spring that all peers simulate. */
TANDEM_C_API tandem_result tandem_peer_grab(tandem_peer* peer, const tandem_grab_def* def,
                                            uint32_t* grab, tandem_error* error);
/** @param now_ns  the start of the step to come */
TANDEM_C_API tandem_result tandem_peer_move(tandem_peer* peer, uint32_t grab, tandem_vec3 anchor,
                                            int64_t now_ns, tandem_error* error);
TANDEM_C_API tandem_result tandem_peer_release(tandem_peer* peer, uint32_t grab,
                                               tandem_error* error);
TANDEM_C_API void tandem_act_def_init(tandem_act_def* def);
/** Kick a shared body, or put it somewhere, here and as of the same session time at all peers.
 * Between steps. */
TANDEM_C_API tandem_result tandem_peer_act(tandem_peer* peer, const tandem_act_def* def,
                                           tandem_error* error);
TANDEM_C_API void tandem_peer_get_stats(const tandem_peer* peer, tandem_peer_stats* stats);

/* ---- sessions: library tandem_c_session ---- */

/** One participant of a session with all that it runs on: clock, steps of fixed length, peer,
 * transport, events. It steps its world, which nothing else may step meanwhile:
 *
 *     tandem_session* session = tandem_session_create_tcp(world, &tcp, &def, &error);
 *     tandem_session_share(session, "cube", cube, 0, NULL, &error);
 *     each frame:  tandem_session_advance(session, tandem_session_now(session), ...);
 *
 * What its functions call must let no exception out, and neither advances nor destroys it. */
typedef struct tandem_session tandem_session;

/** Makes the body that `what` describes, which has come from another member (untrusted: any bytes,
 * and one more that is 0) or from tandem_session_spawn. The session sets where it is.
 * @return not 0 where `body` was written; 0: there is no such thing */
typedef int32_t (*tandem_make)(void* user, const char* what, size_t size, tandem_body* body);
/** Takes a body out of the world that tandem_make has made. */
typedef void (*tandem_remove)(void* user, tandem_body body);
/** Session time, ns. */
typedef int64_t (*tandem_clock)(void* user);
/** Before each step, which begins at `now_ns`: to move hands, push, read events. */
typedef void (*tandem_before_step)(void* user, int64_t now_ns);

typedef struct tandem_session_def {
  double rate;          /**< steps a second, 0.1 to 1e4; 60 */
  tandem_peer_def peer; /**< as of tandem_peer_def_init */
  /* To spawn; all members have both functions, or none has: */
  tandem_make make;            /**< null */
  tandem_remove remove;        /**< null */
  uint32_t max_spawned;        /**< bodies at a time, of all members, > 0; 1024 */
  uint32_t max_spawned_of_one; /**< likewise of one member; 256 */
  tandem_clock clock; /**< null: the transport's, where it has one, else the system's clock */
  void* user;         /**< first argument of the three */
} tandem_session_def;

/** A session key, or an X25519 key of a peer. */
typedef struct tandem_key {
  uint8_t bytes[32];
} tandem_key;

typedef struct tandem_trusted {
  uint64_t peer;
  tandem_key public_key;
} tandem_trusted;

/** Who may take part where frames are protected. All of it is read during the call alone. */
typedef struct tandem_credentials {
  const tandem_key* session_key; /**< the same of all members, not zero */
  const tandem_key* identity;    /**< secret of this peer; null: a new one */
  /** Other peers; neither they nor an organiser: any member. */
  const tandem_trusted* trusted;
  size_t trusted_count;
  const tandem_key* organiser; /**< whose certificates let others in: his public key; null: none */
  const void* certificate;     /**< of this peer, where there is an organiser */
  size_t certificate_size;     /**< bytes */
} tandem_credentials;

/** What one process brings to a session over TCP. */
typedef struct tandem_tcp_def {
  uint64_t self;              /**< unique in the session, never 0 */
  uint64_t scene_hash;        /**< peers with another one are refused; 0 */
  int32_t listen_port;        /**< 0: a free one, see tandem_session_port; -1: it only dials; -1 */
  int32_t insecure;           /**< not 0: no key and yet other addresses than loopback ones; 0 */
  const char* listen_address; /**< numeric; null: "0.0.0.0"; "::" is IPv6 and IPv4 */
  const char* connect; /**< "HOST:PORT" of others, with spaces between; one is enough; null: none */
  tandem_credentials credentials; /**< session_key may be null: loopback addresses only */
} tandem_tcp_def;

/** Where session time comes from. */
typedef enum tandem_clock_source TANDEM_C_ENUM {
  TANDEM_CLOCK_SESSION = 0, /**< agreed on in the session */
  TANDEM_CLOCK_SYSTEM = 1,  /**< hosts are disciplined by PTP or NTP */
  TANDEM_CLOCK_NONE = 2     /**< each peer has its own; states are dated where they arrive */
} tandem_clock_source;

/** What one process brings to a session over UDP, which is encrypted always. */
typedef struct tandem_udp_def {
  uint64_t self;              /**< unique in the session, never 0 */
  uint64_t scene_hash;        /**< peers with another one are refused; 0 */
  int32_t listen_port;        /**< 0: a free one, see tandem_session_port; 0 */
  tandem_clock_source clock;  /**< TANDEM_CLOCK_SESSION */
  const char* listen_address; /**< numeric; null: "0.0.0.0"; "::" is IPv6 and IPv4 */
  const char* connect; /**< "HOST:PORT" of others, with spaces between; one is enough; null: none */
  tandem_credentials credentials; /**< with a session key */
  double kbit_per_s;              /**< budget of each link, headers counted; 256 */
  int32_t relay; /**< not 0: pass on for peers that do not reach each other, and be passed on; 1 */
} tandem_udp_def;

typedef enum tandem_step_status TANDEM_C_ENUM {
  TANDEM_STEP_OK = 0,
  TANDEM_STEP_NON_FINITE = 1, /**< a body became NaN or infinite and was put back */
  TANDEM_STEP_INVALID = 2     /**< session time is below a step: none was made */
} tandem_step_status;

/** What tandem_session_advance did. */
typedef struct tandem_progress {
  int32_t steps;
  tandem_step_status status; /**< of the first step that was not TANDEM_STEP_OK */
  int64_t skipped_ns;        /**< of session time that were jumped over */
  int64_t lag_ns;            /**< that the world is behind */
  int64_t held_ns;           /**< > 0: session time is behind by so much, nothing moves */
  int32_t stepped_elsewhere; /**< not 0: something else has stepped the world since the last call */
} tandem_progress;

/** Another peer as the transport sees it. */
typedef struct tandem_member {
  uint64_t id;
  int32_t connected;
  char reason[128];  /**< why it is not connected; ends with 0, cut where it is longer */
  double round_trip; /**< s, smoothed; -1: not known */
  double kbit_per_s; /**< what the way there bears now; 0: not known */
  uint64_t packets_in, packets_out, bytes_in, bytes_out;
} tandem_member;

typedef struct tandem_session_stats {
  tandem_peer_stats peer;
  uint64_t spawns_refused;  /**< requests of other members to spawn or despawn */
  uint64_t events_lost;     /**< too much waited for somebody */
  uint64_t events_rejected; /**< packets that could not be read */
} tandem_session_stats;

/** A new key, of the system's generator. An error in builds without libsodium. */
TANDEM_C_SESSION_API tandem_result tandem_key_make(tandem_key* key, tandem_error* error);
/** The key to give to the others. Likewise. */
TANDEM_C_SESSION_API tandem_result tandem_key_public(const tandem_key* identity, tandem_key* key,
                                                     tandem_error* error);

/** A peer's id that nobody without the secret of the key can have. 0 of a null key, and in builds
 * without libsodium. */
TANDEM_C_SESSION_API uint64_t tandem_key_peer(const tandem_key* public_key);

TANDEM_C_SESSION_API void tandem_session_def_init(tandem_session_def* def);
TANDEM_C_SESSION_API void tandem_tcp_def_init(tandem_tcp_def* def);
TANDEM_C_SESSION_API void tandem_udp_def_init(tandem_udp_def* def);
/* The world must outlive it and have no peer. Null where it failed. */
TANDEM_C_SESSION_API tandem_session* tandem_session_create_tcp(tandem_world* world,
                                                               const tandem_tcp_def* tcp,
                                                               const tandem_session_def* def,
                                                               tandem_error* error);
/** Fails in builds without libsodium. */
TANDEM_C_SESSION_API tandem_session* tandem_session_create_udp(tandem_world* world,
                                                               const tandem_udp_def* udp,
                                                               const tandem_session_def* def,
                                                               tandem_error* error);
/** Over a transport that outlives it, a network's or the caller's, and no channel's: a session has
 * its own events. */
TANDEM_C_SESSION_API tandem_session* tandem_session_create(tandem_world* world,
                                                           tandem_transport* transport,
                                                           const tandem_session_def* def,
                                                           tandem_error* error);
/** Tells the others that it goes. Before its world and its transport. Null: nothing happens. */
TANDEM_C_SESSION_API void tandem_session_destroy(tandem_session* session);

/** Of this peer. */
TANDEM_C_SESSION_API uint64_t tandem_session_self(const tandem_session* session);
/** The port of its own socket; 0: there is none. */
TANDEM_C_SESSION_API int32_t tandem_session_port(const tandem_session* session);
/** Session time now, ns. Of a null session 0. */
TANDEM_C_SESSION_API int64_t tandem_session_now(tandem_session* session);
/** Make the steps that are due at `now_ns`, and only those: it waits for nothing. The first call
 * begins. Contacts of the world are those of the last step.
 * @param before_step  may be null, as may be `user`, its first argument, and `progress` */
TANDEM_C_SESSION_API tandem_result tandem_session_advance(tandem_session* session, int64_t now_ns,
                                                          tandem_before_step before_step,
                                                          void* user, tandem_progress* progress,
                                                          tandem_error* error);

/** Share a body with all members that share one by the same name.
 * @param owner  the peer that alone moves it; 0 = nobody owns it
 * @param id  what it is known by, tandem_shared_id_of(name); may be null */
TANDEM_C_SESSION_API tandem_result tandem_session_share(tandem_session* session, const char* name,
                                                        tandem_body body, uint64_t owner,
                                                        tandem_shared_id* id, tandem_error* error);
/** All bodies of one thing, as "name/0", "name/1" and so on, or none of them. */
TANDEM_C_SESSION_API tandem_result tandem_session_share_all(tandem_session* session,
                                                            const char* name,
                                                            const tandem_body* bodies, size_t count,
                                                            uint64_t owner, tandem_error* error);
TANDEM_C_SESSION_API tandem_result tandem_session_unshare(tandem_session* session,
                                                          tandem_shared_id id, tandem_error* error);
/** The instance of a shared body here. */
TANDEM_C_SESSION_API tandem_result tandem_session_body(const tandem_session* session,
                                                       tandem_shared_id id, tandem_body* body,
                                                       tandem_error* error);

/** Hold a shared body with a spring that all members simulate. */
TANDEM_C_SESSION_API tandem_result tandem_session_grab(tandem_session* session,
                                                       const tandem_grab_def* def, uint32_t* grab,
                                                       tandem_error* error);
/** Where the hand is as the next step begins, m, world.
 * @param holds  0: no longer, it was released or its body is gone; may be null */
TANDEM_C_SESSION_API tandem_result tandem_session_move(tandem_session* session, uint32_t grab,
                                                       tandem_vec3 anchor, int32_t* holds,
                                                       tandem_error* error);
/** Let go, if it still holds. */
TANDEM_C_SESSION_API tandem_result tandem_session_release(tandem_session* session, uint32_t grab,
                                                          tandem_error* error);
/** As tandem_peer_act. */
TANDEM_C_SESSION_API tandem_result tandem_session_act(tandem_session* session,
                                                      const tandem_act_def* def,
                                                      tandem_error* error);

/** Make a body at every member, the later ones included, and share it.
 * @param what  what tandem_make is given at every member, 512 bytes at most; UTF-8, say
 * @param twist  null: at rest     @param id  may be null */
TANDEM_C_SESSION_API tandem_result tandem_session_spawn(tandem_session* session, const char* what,
                                                        const tandem_pose* pose,
                                                        const tandem_twist* twist,
                                                        tandem_shared_id* id, tandem_error* error);
/** Remove a body at every member that any of them has spawned. */
TANDEM_C_SESSION_API tandem_result tandem_session_despawn(tandem_session* session,
                                                          tandem_shared_id id, tandem_error* error);

/** Who has connected during the last advance. Copies at most `capacity` ids, in the order in which
 * it was seen; from within tandem_before_step up to that step. @return how many there are */
TANDEM_C_SESSION_API size_t tandem_session_joined(const tandem_session* session, uint64_t* peers,
                                                  size_t capacity);
/** Likewise whose connection has ended. */
TANDEM_C_SESSION_API size_t tandem_session_left(const tandem_session* session, uint64_t* peers,
                                                size_t capacity);
/** All peers ever seen, by ascending id. Copies at most `capacity`. @return how many there are */
TANDEM_C_SESSION_API size_t tandem_session_members(tandem_session* session, tandem_member* members,
                                                   size_t capacity);

/** A message of the application. It leaves before the next step.
 * @param topic  64 bytes at most; those that begin with "tandem." are the session's
 * @param to  0: all */
TANDEM_C_SESSION_API tandem_result tandem_session_send(tandem_session* session, const char* topic,
                                                       const void* payload, size_t size,
                                                       uint64_t to, tandem_error* error);
/** What has come during the last advance, from within tandem_before_step up to that step, without
 * the session's own. Valid until the next advance. Copies at most `capacity`.
 * @return how many there are */
TANDEM_C_SESSION_API size_t tandem_session_events(const tandem_session* session,
                                                  tandem_event* events, size_t capacity);
TANDEM_C_SESSION_API void tandem_session_get_stats(const tandem_session* session,
                                                   tandem_session_stats* stats);

/* ---- scene files: library tandem_c_files ---- */

/** Names and whatever else a file has beside the world that is made of it. */
typedef struct tandem_scene_file tandem_scene_file;

typedef enum tandem_scene_format TANDEM_C_ENUM {
  TANDEM_SCENE_JSON = 0, /**< Tandem's own, docs/scene_files.md */
  TANDEM_SCENE_GLTF = 1  /**< glTF 2.0 with physics, or .glb; its y is up, the world's z is */
} tandem_scene_format;

/** Valid as long as the file. */
typedef struct tandem_named_body {
  const char* name; /**< may be empty */
  tandem_body body;
} tandem_named_body;

typedef struct tandem_named_joint {
  const char* name; /**< may be empty */
  tandem_joint joint;
} tandem_named_joint;

/** A world from a file; one that ends in .gltf or .glb is glTF. Strangers' files may be read. An
 * error names file, place in it, rule and value. Null where it failed.
 * @param path  UTF-8
 * @param def  gravity is the file's where that says one
 * @param file  may be null; to be destroyed, before or after the world */
TANDEM_C_FILES_API tandem_world* tandem_scene_load(const char* path, const tandem_world_def* def,
                                                   tandem_scene_file** file, tandem_error* error);
/** The same of a text in memory.
 * @param size  bytes, without a 0 at the end
 * @param folder  of glTF, where its buffers may be files; UTF-8 */
TANDEM_C_FILES_API tandem_world* tandem_scene_parse(tandem_scene_format format, const char* text,
                                                    size_t size, const char* folder,
                                                    const tandem_world_def* def,
                                                    tandem_scene_file** file, tandem_error* error);
/** The world stays. Null: nothing happens. */
TANDEM_C_FILES_API void tandem_scene_file_destroy(tandem_scene_file* file);
/** In the file's order. Copies at most `capacity`. @return how many there are */
TANDEM_C_FILES_API size_t tandem_scene_file_bodies(const tandem_scene_file* file,
                                                   tandem_named_body* bodies, size_t capacity);
TANDEM_C_FILES_API size_t tandem_scene_file_joints(const tandem_scene_file* file,
                                                   tandem_named_joint* joints, size_t capacity);
/** What the file has and the world has not, with its place. */
TANDEM_C_FILES_API size_t tandem_scene_file_warnings(const tandem_scene_file* file,
                                                     const char** warnings, size_t capacity);
/** The first one of that name. */
TANDEM_C_FILES_API tandem_result tandem_scene_file_find_body(const tandem_scene_file* file,
                                                             const char* name, tandem_body* body,
                                                             tandem_error* error);
TANDEM_C_FILES_API tandem_result tandem_scene_file_find_joint(const tandem_scene_file* file,
                                                              const char* name, tandem_joint* joint,
                                                              tandem_error* error);
/** Where the frame of that name is now, world: of a body's shape, where tandem_body_state has the
 * centre of mass. */
TANDEM_C_FILES_API tandem_result tandem_scene_file_pose(const tandem_scene_file* file,
                                                        const char* name, tandem_pose* pose,
                                                        tandem_error* error);
/** One more body, from an element as Tandem's format has them in "bodies".
 * @param size  bytes, without a 0 at the end */
TANDEM_C_FILES_API tandem_result tandem_scene_add_body(tandem_world* world, const char* text,
                                                       size_t size, tandem_body* body,
                                                       tandem_error* error);
/** The world as text of Tandem's format, with a 0 at the end.
 * @param file  its names; null: none
 * @param size  in: bytes of `buffer`, out: needed */
TANDEM_C_FILES_API tandem_result tandem_scene_write(const tandem_world* world,
                                                    const tandem_scene_file* file, char* buffer,
                                                    size_t* size, tandem_error* error);

#undef TANDEM_C_ENUM

#ifdef __cplusplus
}
#endif

#endif
