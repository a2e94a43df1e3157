// A ring of powder made by this program, in two lights: particles.ppm, the maps as raw floats, and the scene
// for `gobo`.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>
#include "gobo.h"

static void check(int code, const char *what) {
    if (code == GOBO_OK) return;
    std::fprintf(stderr, "%s: %s (code %d)\n", what, gobo_message(), code);
    std::exit(1);
}

static void write(const std::string &path, const void *bytes, size_t count, const std::string &head = "") {
    FILE *file = std::fopen(path.c_str(), "wb");
    if (file && std::fwrite(head.data(), 1, head.size(), file) == head.size() &&
        std::fwrite(bytes, 1, count, file) == count && std::fclose(file) == 0) return;
    std::perror(path.c_str());
    std::exit(1);
}

// The rest of the scene, as in a scene file.
static const std::string scene_text = R"(
[camera]
eye = [0, 3.2, 4.2]
target = [0, 0.5, 0]
size = [480, 300]
[shadow]
size = 256
[[light]]
name = "warm"
kind = "spot"
position = [-2, 4, 1.5]
direction = [2, -4, -1.5]
angle = 60
intensity = 40
[[light]]
name = "sky"
kind = "directional"
direction = [0.4, -1, -0.3]
[[material]]
name = "floor"
transfer = "opaque"
[[material]]
name = "powder"
transfer = "filter"
[[shape]]
kind = "plane"
material = "floor"
scale = [12, 1, 12])";

int main(int count_of_arguments, char **arguments) {
    const std::string out = std::string(count_of_arguments > 1 ? arguments[1] : ".") + "/";
    const size_t count = 20000;
    std::vector<float> centers, colors, radii(count, 0.03f);
    std::string csv = "x,y,z,radius,red,green,blue,alpha\n";
    for (size_t i = 0; i < count; i++) {
        const float turn = 6.2831853f * i / count, twist = 37 * turn;
        const float ring = 1 + 0.3f * std::cos(twist);
        const float at[3] = {ring * std::cos(turn), 0.8f + 0.3f * std::sin(twist), ring * std::sin(turn)};
        const float color[4] = {0.5f + 0.45f * std::cos(turn), 0.5f + 0.45f * std::cos(turn + 2.1f),
                                0.5f + 0.45f * std::cos(turn + 4.2f), 0.15f};
        centers.insert(centers.end(), at, at + 3);
        colors.insert(colors.end(), color, color + 4);
        char row[200];
        std::snprintf(row, sizeof row, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g\n", at[0], at[1], at[2], radii[i],
                      color[0], color[1], color[2], color[3]);
        csv += row;
    }
    const std::string text = scene_text + "\n[[particles]]\nfile = \"particles.csv\"\nmaterial = \"powder\"\n";
    write(out + "particles.csv", csv.data(), csv.size());
    write(out + "particles.toml", text.data(), text.size());
    gobo_scene *scene;
    gobo_renderer *renderer;
    gobo_frame *frame;
    check(gobo_scene_from_text(scene_text.c_str(), nullptr, &scene), "scene");
    check(gobo_scene_add_particles(scene, count, &centers[0], &radii[0], &colors[0], "powder", nullptr), "particles");
    check(gobo_renderer_open(GOBO_AUTO, nullptr, &renderer), "renderer");
    check(gobo_render(renderer, scene, GOBO_PICTURE | GOBO_MAPS, &frame), "frame");

    gobo_picture picture;
    check(gobo_frame_picture(frame, &picture), "picture");
    const std::string head = "P6\n" + std::to_string(picture.size[0]) + " " + std::to_string(picture.size[1]) + "\n255\n";
    write(out + "particles.ppm", picture.srgb, size_t(3) * picture.size[0] * picture.size[1], head);
    for (size_t i = 0; i < gobo_frame_map_count(frame); i++) {
        gobo_map map;
        check(gobo_frame_map(frame, i, &map), "map");
        const size_t bytes = sizeof(float) * map.size[0] * map.size[1];
        const std::string name = out + (map.light == 0 ? "warm." : "sky.") + map.view;
        write(name + ".filter", map.filter, 3 * bytes);
        write(name + ".nearest", map.nearest, bytes);
        write(name + ".opaque", map.opaque, bytes);
        write(name + ".curve", map.curve, 5 * map.nodes * bytes);
    }
    gobo_frame_free(frame);
    gobo_renderer_free(renderer);
    gobo_scene_free(scene);
}
