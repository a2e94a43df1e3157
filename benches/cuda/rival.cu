// What a plain CUDA program does with the soft discs of `gobo bench`: project, sort by depth (CUB), count, scan, emit, sort by tile
// (CUB), ranges, and one thread a texel that multiplies its tile's discs front to back, staged in shared memory; filter product and
// nearest depth. Then CUB's sort alone. A line of JSON for each case: median times of 20 frames by events [ms].
//
// rival [CASTERSxTEXELS[@OPACITY]]... ; tools/cuda.sh builds it.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cub/cub.cuh>
#include <cuda_fp16.h>
#include <random>
#include <string>
#include <vector>

constexpr int SIZE = 1024, TILE = 16, TILES = SIZE / TILE; // of the map [texels], of a tile [texels], of a row [tiles]
constexpr int TILE_BITS = 12, DEPTH_BITS = 16;
constexpr int WARM_UP = 5, FRAMES = 20;
constexpr int LANES = 256;

#define CHECK(call)                                                                                  \
    do {                                                                                             \
        cudaError_t error = (call);                                                                  \
        if (error != cudaSuccess) {                                                                  \
            fprintf(stderr, "rival: %s, line %d\n", cudaGetErrorString(error), __LINE__);            \
            exit(1);                                                                                 \
        }                                                                                            \
    } while (0)

struct Disc {
    float3 center; // [m], -1 to 1
    float radius;  // [m]
    float3 color;
    float opacity;
};

// Device memory of `count` elements.
template <typename T> struct Buffer {
    T *data = nullptr;
    explicit Buffer(size_t count) { CHECK(cudaMalloc(&data, std::max<size_t>(count, 1) * sizeof(T))); }
    Buffer(const Buffer &) = delete;
    ~Buffer() { cudaFree(data); }
};

struct Rect {
    int x0, y0, x1, y1;
};

// Tiles of the disc's box; none if the first is behind the last.
__device__ Rect rect_of(float4 at) {
    return {max(0, (int)floorf((at.x - at.w) / TILE)), max(0, (int)floorf((at.y - at.w) / TILE)),
            min(TILES - 1, (int)floorf((at.x + at.w) / TILE)), min(TILES - 1, (int)floorf((at.y + at.w) / TILE))};
}

// Whether the disc touches a texel centre of the tile.
__device__ bool touches(float4 at, int x, int y) {
    float dx = fminf(fmaxf(at.x, x * TILE + .5f), x * TILE + TILE - .5f) - at.x;
    float dy = fminf(fmaxf(at.y, y * TILE + .5f), y * TILE + TILE - .5f) - at.y;
    return dx * dx + dy * dy < at.w * at.w;
}

// Centre, depth and radius in the map; what each channel loses, and the opacity, as halves; the depth key.
__global__ void project(const Disc *discs, int count, float4 *places, uint2 *colors, unsigned short *keys, unsigned *ids) {
    int i = blockIdx.x * LANES + threadIdx.x;
    if (i >= count) return;
    Disc disc = discs[i];
    float radius = disc.radius * SIZE * .5f, opacity = disc.opacity;
    if (radius < .7071f) { // enlarged, fainter by the ratio of the areas
        opacity *= radius * radius / .5f;
        radius = .7071f;
    }
    float depth = (1 - disc.center.z) * .5f;
    places[i] = make_float4((disc.center.x + 1) * SIZE * .5f, (1 - disc.center.y) * SIZE * .5f, depth, radius);
    __half2 rg = __floats2half2_rn(opacity * (1 - disc.color.x), opacity * (1 - disc.color.y));
    __half2 ba = __floats2half2_rn(opacity * (1 - disc.color.z), opacity);
    colors[i] = make_uint2(*(unsigned *)&rg, *(unsigned *)&ba);
    keys[i] = (unsigned short)(fminf(fmaxf(depth, 0.f), 1.f) * 65534);
    ids[i] = i;
}

__global__ void count_tiles(const float4 *places, const unsigned *sorted, int count, unsigned *counts) {
    int i = blockIdx.x * LANES + threadIdx.x;
    if (i >= count) return;
    float4 at = places[sorted[i]];
    Rect rect = rect_of(at);
    unsigned touched = 0;
    for (int y = rect.y0; y <= rect.y1; y++)
        for (int x = rect.x0; x <= rect.x1; x++) touched += touches(at, x, y);
    counts[i] = touched;
}

__global__ void emit(const float4 *places, const unsigned *sorted, int count, const unsigned *offsets,
                     unsigned short *tiles, unsigned *values) {
    int i = blockIdx.x * LANES + threadIdx.x;
    if (i >= count) return;
    float4 at = places[sorted[i]];
    Rect rect = rect_of(at);
    unsigned slot = offsets[i];
    for (int y = rect.y0; y <= rect.y1; y++)
        for (int x = rect.x0; x <= rect.x1; x++)
            if (touches(at, x, y)) {
                tiles[slot] = y * TILES + x;
                values[slot++] = sorted[i];
            }
}

__global__ void find_ranges(const unsigned short *tiles, unsigned count, uint2 *ranges) {
    unsigned i = blockIdx.x * LANES + threadIdx.x;
    if (i >= count) return;
    unsigned tile = tiles[i];
    if (i == 0 || tiles[i - 1] != tile) ranges[tile].x = i;
    if (i == count - 1 || tiles[i + 1] != tile) ranges[tile].y = i + 1;
}

__global__ void __launch_bounds__(LANES)
    accumulate(const float4 *places, const uint2 *colors, const unsigned *values, const uint2 *ranges, float4 *filters, float *nearest) {
    __shared__ float4 staged[LANES], lost[LANES];
    uint2 range = ranges[blockIdx.y * TILES + blockIdx.x];
    int column = blockIdx.x * TILE + threadIdx.x % TILE, row = blockIdx.y * TILE + threadIdx.x / TILE;
    float3 light = make_float3(1, 1, 1);
    float depth = 1;
    for (unsigned first = range.x; first < range.y; first += LANES) {
        if (first + threadIdx.x < range.y) {
            unsigned id = values[first + threadIdx.x];
            float4 at = places[id];
            at.w = 1 / (at.w * at.w);
            staged[threadIdx.x] = at;
            uint2 color = colors[id];
            float2 rg = __half22float2(*(__half2 *)&color.x), ba = __half22float2(*(__half2 *)&color.y);
            lost[threadIdx.x] = make_float4(rg.x, rg.y, ba.x, ba.y);
        }
        __syncthreads();
        int many = min((unsigned)LANES, range.y - first);
        for (int i = 0; i < many; i++) {
            float4 at = staged[i];
            float dx = column + .5f - at.x, dy = row + .5f - at.y;
            float inside = 1 - (dx * dx + dy * dy) * at.w;
            if (inside > 0) {
                float profile = inside * inside;
                float4 color = lost[i];
                light.x *= 1 - profile * color.x;
                light.y *= 1 - profile * color.y;
                light.z *= 1 - profile * color.z;
                if (profile * color.w >= 1.f / 255) depth = fminf(depth, at.z);
            }
        }
        __syncthreads();
    }
    filters[row * SIZE + column] = make_float4(light.x, light.y, light.z, 1);
    nearest[row * SIZE + column] = depth;
}

static double median(std::vector<float> times) {
    std::sort(times.begin(), times.end());
    return times[times.size() / 2];
}

// Medians between neighbouring events of a frame, then of the whole.
template <typename Frame> std::vector<double> timed(int steps, Frame frame) {
    std::vector<cudaEvent_t> events(steps + 1);
    for (auto &event : events) CHECK(cudaEventCreate(&event));
    std::vector<std::vector<float>> times(steps + 1);
    for (int run = 0; run < WARM_UP + FRAMES; run++) {
        frame(events);
        CHECK(cudaDeviceSynchronize());
        if (run < WARM_UP) continue;
        for (int i = 0; i <= steps; i++) {
            float ms;
            CHECK(cudaEventElapsedTime(&ms, events[i == steps ? 0 : i], events[i == steps ? steps : i + 1]));
            times[i].push_back(ms);
        }
    }
    for (auto &event : events) cudaEventDestroy(event);
    std::vector<double> medians;
    for (auto &of_step : times) medians.push_back(median(of_step));
    return medians;
}

static void run(int count, float diameter, float opacity) {
    std::vector<Disc> discs(count);
    std::mt19937 chance(7);
    std::uniform_real_distribution<float> unit(0, 1);
    for (auto &disc : discs) {
        disc.center = make_float3(unit(chance) * 2 - 1, unit(chance) * 2 - 1, unit(chance) * 2 - 1);
        disc.radius = diameter * .5f * (.75f + .5f * unit(chance)) * 2 / SIZE;
        disc.color = make_float3(unit(chance), unit(chance), unit(chance));
        disc.opacity = opacity;
    }
    Buffer<Disc> input(count);
    CHECK(cudaMemcpy(input.data, discs.data(), count * sizeof(Disc), cudaMemcpyHostToDevice));
    Buffer<float4> places(count);
    Buffer<uint2> colors(count);
    Buffer<unsigned short> keys(count), sorted_keys(count);
    Buffer<unsigned> ids(count), sorted(count), counts(count + 1), offsets(count + 1);
    CHECK(cudaMemset(counts.data, 0, (count + 1) * sizeof(unsigned)));
    size_t of_scan = 0, of_depths = 0, of_tiles = 0;
    CHECK(cub::DeviceScan::ExclusiveSum(nullptr, of_scan, counts.data, offsets.data, count + 1));
    CHECK(cub::DeviceRadixSort::SortPairs(nullptr, of_depths, keys.data, sorted_keys.data, ids.data, sorted.data, count, 0, DEPTH_BITS));
    Buffer<char> scan_room(of_scan), depth_room(of_depths);
    int blocks = (count + LANES - 1) / LANES;
    auto depths = [&] {
        CHECK(cub::DeviceRadixSort::SortPairs(depth_room.data, of_depths, keys.data, sorted_keys.data, ids.data, sorted.data, count, 0,
                                              DEPTH_BITS));
    };
    auto scan = [&] {
        count_tiles<<<blocks, LANES>>>(places.data, sorted.data, count, counts.data);
        CHECK(cub::DeviceScan::ExclusiveSum(scan_room.data, of_scan, counts.data, offsets.data, count + 1));
    };
    project<<<blocks, LANES>>>(input.data, count, places.data, colors.data, keys.data, ids.data);
    depths();
    scan();
    unsigned pairs;
    CHECK(cudaMemcpy(&pairs, offsets.data + count, sizeof pairs, cudaMemcpyDeviceToHost));
    Buffer<unsigned short> tiles(pairs), sorted_tiles(pairs);
    Buffer<unsigned> values(pairs), sorted_values(pairs);
    CHECK(cub::DeviceRadixSort::SortPairs(nullptr, of_tiles, tiles.data, sorted_tiles.data, values.data, sorted_values.data, pairs, 0,
                                          TILE_BITS));
    Buffer<char> tile_room(of_tiles);
    Buffer<uint2> ranges(TILES * TILES);
    Buffer<float4> filters(SIZE * SIZE);
    Buffer<float> nearest(SIZE * SIZE);
    auto times = timed(5, [&](std::vector<cudaEvent_t> &events) {
        cudaEventRecord(events[0]);
        project<<<blocks, LANES>>>(input.data, count, places.data, colors.data, keys.data, ids.data);
        cudaEventRecord(events[1]);
        depths();
        cudaEventRecord(events[2]);
        scan();
        emit<<<blocks, LANES>>>(places.data, sorted.data, count, offsets.data, tiles.data, values.data);
        cudaEventRecord(events[3]);
        CHECK(cub::DeviceRadixSort::SortPairs(tile_room.data, of_tiles, tiles.data, sorted_tiles.data, values.data, sorted_values.data,
                                              pairs, 0, TILE_BITS));
        cudaMemsetAsync(ranges.data, 0, TILES * TILES * sizeof(uint2));
        find_ranges<<<(pairs + LANES - 1) / LANES, LANES>>>(sorted_tiles.data, pairs, ranges.data);
        cudaEventRecord(events[4]);
        accumulate<<<dim3(TILES, TILES), LANES>>>(places.data, colors.data, sorted_values.data, ranges.data, filters.data, nearest.data);
        cudaEventRecord(events[5]);
    });
    CHECK(cudaGetLastError());
    std::vector<float4> light(SIZE * SIZE);
    CHECK(cudaMemcpy(light.data(), filters.data, light.size() * sizeof(float4), cudaMemcpyDeviceToHost));
    double mean = 0;
    for (auto &texel : light) mean += texel.x;
    printf("{\"casters\": %d, \"footprint\": %g, \"opacity\": %g, \"cuda_ms\": %.4f, \"project\": %.4f, \"depths\": %.4f, "
           "\"emit\": %.4f, \"tiles\": %.4f, \"accumulate\": %.4f, \"pairs\": %u, \"mean\": %.4f}\n",
           count, diameter, opacity, times[5], times[0], times[1], times[2], times[3], times[4], pairs, mean / light.size());
}

// CUB alone: 32-bit keys and values, by the lowest `bits`.
static void sort(int count, int bits) {
    std::vector<unsigned> numbers(count);
    std::mt19937 chance(1);
    for (auto &number : numbers) number = chance();
    Buffer<unsigned> keys(count), values(count), sorted_keys(count), sorted_values(count);
    CHECK(cudaMemcpy(keys.data, numbers.data(), count * sizeof(unsigned), cudaMemcpyHostToDevice));
    size_t size = 0;
    CHECK(cub::DeviceRadixSort::SortPairs(nullptr, size, keys.data, sorted_keys.data, values.data, sorted_values.data, count, 0, bits));
    Buffer<char> room(size);
    auto times = timed(1, [&](std::vector<cudaEvent_t> &events) {
        cudaEventRecord(events[0]);
        CHECK(cub::DeviceRadixSort::SortPairs(room.data, size, keys.data, sorted_keys.data, values.data, sorted_values.data, count, 0,
                                              bits));
        cudaEventRecord(events[1]);
    });
    printf("{\"sort\": %d, \"bits\": %d, \"cub_ms\": %.4f}\n", count, bits, times[1]);
}

// 10k, 1m or a plain number.
static int number(const std::string &text) {
    double value = atof(text.c_str());
    return (int)(value * (text.find('m') != text.npos ? 1e6 : text.find('k') != text.npos ? 1e3 : 1));
}

int main(int count, char **arguments) {
    for (int i = 1; i < count; i++) {
        std::string text = arguments[i];
        size_t x = text.find('x'), at = text.find('@');
        if (x == text.npos || number(text) < 1) {
            fprintf(stderr, "rival: %s is not a case such as 100kx16 or 1mx6@0.5\n", arguments[i]);
            return 2;
        }
        float opacity = at == text.npos ? .02f : (float)atof(text.c_str() + at + 1);
        run(number(text.substr(0, x)), (float)atof(text.c_str() + x + 1), opacity);
    }
    for (int pairs : {1000000, 3500000, 16000000})
        for (int bits : {12, 16, 32}) sort(pairs, bits);
}
