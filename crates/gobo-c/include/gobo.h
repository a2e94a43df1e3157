/*
 * gobo from C and C++: coloured translucent shadows.
 *
 * World space is right-handed with y up, in metres; colours are linear. Functions return GOBO_OK or a code,
 * with the problem and the remedy in gobo_message(). Objects are freed by the function that names them, and
 * NULL is freed without effect. An object is used by one thread at a time, which may change between calls.
 *
 * The caller promises: pointers are NULL or valid for the whole call; arrays have the stated lengths, in
 * floats or elements; texts end with a zero; objects were returned by a function here, and are not yet freed.
 * NULL is allowed only where stated, and is GOBO_INPUT elsewhere.
 */
#ifndef GOBO_H
#define GOBO_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Codes. */
#define GOBO_OK 0
#define GOBO_INPUT 1  /* an argument */
#define GOBO_SCENE 2  /* a file, or a scene's text: the message has the line, the column and the remedy */
#define GOBO_DEVICE 3 /* no adapter, or one that refuses */
#define GOBO_MEMORY 4
#define GOBO_BUG 5 /* of gobo: free the objects that the call used, and report the message */

/* Interfaces of gobo_renderer_open. */
#define GOBO_AUTO 0
#define GOBO_VULKAN 1
#define GOBO_METAL 2
#define GOBO_DX12 3
#define GOBO_GL 4
#define GOBO_CPU 5 /* no adapter: slow, and the same on all machines */

/* Kinds of lights. */
#define GOBO_DIRECTIONAL 0
#define GOBO_SPOT 1
#define GOBO_POINT 2

/* Outputs of gobo_render; they can be added. */
#define GOBO_PICTURE 1
#define GOBO_MAPS 2

typedef struct gobo_scene gobo_scene;
typedef struct gobo_renderer gobo_renderer;
typedef struct gobo_frame gobo_frame;

/* Numbers of a light; gobo_light_default() has the defaults of a scene file. */
typedef struct gobo_light {
    uint32_t kind;
    float position[3];  /* of spots and points [m] */
    float direction[3]; /* in which light travels, of directional lights and spots; any length */
    float angle;        /* opening angle of a spot's whole cone [radians] */
    float color[3];
    float intensity;
    uint32_t map_size; /* edge of each map, 16 to 4096 [texels]; 0: as large as the picture needs */
} gobo_light;

typedef struct gobo_camera {
    float eye[3];    /* [m] */
    float target[3]; /* [m] */
    float up[3];
    float fov_y;      /* vertical field of view [radians] */
    uint32_t size[2]; /* width and height [pixels] */
} gobo_camera;

/* A picture, rows from the top, owned by the frame. */
typedef struct gobo_picture {
    uint32_t size[2];    /* width and height [pixels] */
    const uint8_t *srgb; /* height x width x 3 */
    const float *light;  /* height x width x 3, linear, before exposure and tone curve */
} gobo_picture;

/* The maps of one view of a light, row by row, owned by the frame. Depths go from 0, near, to 1, far. */
typedef struct gobo_map {
    uint32_t light;    /* index of the light */
    const char *view;  /* name of the view, unique among the light's */
    uint32_t size[2];  /* width and height [texels] */
    uint32_t nodes;    /* of a texel's curve: 0 without curves */
    float near_plane;  /* [m] */
    float far_plane;   /* [m] */
    const float *filter;  /* height x width x 3: transmittance of translucent casters */
    const float *nearest; /* height x width: depth of the nearest translucent caster, 1 without one */
    const float *opaque;  /* height x width: depth of the nearest opaque surface, 1 without one */
    const float *colored; /* height x width x 3: opaque depths by channel, with coloured dithering; else NULL */
    const float *curve;   /* height x width x nodes x 5: start (2: unused), end, light behind; or NULL */
    double clip_from_world[16]; /* columns of the matrix */
    double view_from_world[16]; /* columns of the matrix */
} gobo_map;

/* Version of the library: "0.2.0". */
const char *gobo_version(void);
/* Problem and remedy of this thread's last failed call; "" without one. Valid until the next failure. */
const char *gobo_message(void);

/* A scene from the text of a scene file (docs/scene.md). `path`: name of that file; files that the text names
 * are in its folder; NULL: in the working folder. */
int gobo_scene_from_text(const char *text, const char *path, gobo_scene **scene);
/* A scene from any file that the program reads. */
int gobo_scene_load(const char *path, gobo_scene **scene);
void gobo_scene_free(gobo_scene *scene);

/* Sets the time of an animated scene, from its start [s]. */
int gobo_scene_set_time(gobo_scene *scene, double seconds);
int gobo_scene_set_camera(gobo_scene *scene, const gobo_camera *camera);

/* Adds particles. `centers`: count x 3 [m]; `radii`: count [m]; `colors`: count x 4, linear rgb and opacity,
 * NULL: white; `material`: name of one of the scene's. `left_out`: receives the number of invalid particles;
 * with NULL an invalid particle is an error, and none is added. */
int gobo_scene_add_particles(gobo_scene *scene, size_t count, const float *centers, const float *radii,
                             const float *colors, const char *material, size_t *left_out);
/* Adds triangles. `corners`: count x 3 x 3 [m]; as above. */
int gobo_scene_add_triangles(gobo_scene *scene, size_t count, const float *corners, const char *material,
                             size_t *left_out);
/* A white light from straight above. */
gobo_light gobo_light_default(void);
/* Adds a light. `name`: NULL: "light". Its index is the count before. */
int gobo_scene_add_light(gobo_scene *scene, const gobo_light *light, const char *name);
/* Number of lights; 0 for NULL. */
size_t gobo_scene_light_count(const gobo_scene *scene);

/* Opens an adapter. `name`: part of its name, NULL: any. */
int gobo_renderer_open(uint32_t backend, const char *name, gobo_renderer **renderer);
void gobo_renderer_free(gobo_renderer *renderer);

/* Renders a scene: `what` is GOBO_PICTURE, GOBO_MAPS, or both. The maps equal those of `gobo render --maps`,
 * bit for bit. */
int gobo_render(gobo_renderer *renderer, const gobo_scene *scene, uint32_t what, gobo_frame **frame);
void gobo_frame_free(gobo_frame *frame);
/* The picture; GOBO_INPUT if it was not rendered. */
int gobo_frame_picture(const gobo_frame *frame, gobo_picture *picture);
/* Number of views with maps; 0 for NULL. */
size_t gobo_frame_map_count(const gobo_frame *frame);
int gobo_frame_map(const gobo_frame *frame, size_t index, gobo_map *map);

/* Looks up the share of each light that reaches points. `positions`: count x 3 [m]; `normals`: count x 3,
 * NULL: none; `shares`: receives count x lights x 3, 1 where nothing is between. */
int gobo_light_points(gobo_renderer *renderer, const gobo_scene *scene, size_t count, const float *positions,
                      const float *normals, float *shares);

#ifdef __cplusplus
}
#endif
#endif
