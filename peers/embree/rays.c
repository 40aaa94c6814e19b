// Embree on the occlusion rays of a progressive radiosity solve, every shooter's centre to every
// texel's: the yardstick for the CPU solver. Reads what `dump_rays` wrote (benches/embree.rs says
// how), prints JSON. Usage: embree_rays FILE [THREADS]

#include <embree3/rtcore.h>
#include <omp.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>
#include <pmmintrin.h>

// Occluders count between these shares of the way: the faces at both ends lie outside.
#define NEAR 1e-5f
#define FAR (1.0f - 1e-5f)
// Texels per task, and rays per packet.
#define TASK 1024
#define WIDE 16

typedef struct {
    uint32_t triangles, shooters, texels, shots;
    float *corners;   // 9 a triangle
    float *centres;   // 3 a shooter
    float *x, *y, *z; // of the texels, padded to whole packets
    uint32_t *log;    // the shooter of each shot
    uint8_t *answers; // ours, shooter by texel: 0 hidden, 1 seen, 2 facing away
} Dump;

typedef uint64_t (*Trace)(RTCScene, const Dump *, uint32_t shooter, uint32_t first, uint32_t end,
                          uint8_t *hidden);

static void *need(void *memory) {
    if (!memory) {
        fprintf(stderr, "error: out of memory\n");
        exit(1);
    }
    return memory;
}

static void *read_all(FILE *file, size_t count, size_t size) {
    void *data = need(malloc(count * size + 64));
    if (fread(data, size, count, file) != count) {
        fprintf(stderr, "error: the dump is cut short\n");
        exit(2);
    }
    return data;
}

// One coordinate of all texels, so that a packet is filled by wide loads.
static float *axis(const float *points, uint32_t count, int k) {
    uint32_t padded = (count + WIDE - 1) / WIDE * WIDE;
    float *values = need(aligned_alloc(64, padded * sizeof(float) + 64));
    for (uint32_t i = 0; i < padded; i++) values[i] = points[3 * (i < count ? i : count - 1) + k];
    return values;
}

static Dump read_dump(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file) {
        fprintf(stderr, "error: %s cannot be read\n", path);
        exit(2);
    }
    uint32_t *head = read_all(file, 4, sizeof(uint32_t));
    Dump dump = {.triangles = head[0], .shooters = head[1], .texels = head[2], .shots = head[3]};
    dump.corners = read_all(file, 9ul * dump.triangles, sizeof(float));
    dump.centres = read_all(file, 3ul * dump.shooters, sizeof(float));
    float *points = read_all(file, 3ul * dump.texels, sizeof(float));
    dump.x = axis(points, dump.texels, 0);
    dump.y = axis(points, dump.texels, 1);
    dump.z = axis(points, dump.texels, 2);
    dump.log = read_all(file, dump.shots, sizeof(uint32_t));
    dump.answers = read_all(file, (size_t)dump.shooters * dump.texels, 1);
    free(points);
    free(head);
    fclose(file);
    return dump;
}

static RTCScene build(RTCDevice device, const Dump *dump) {
    RTCGeometry mesh = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    size_t corners = 3ul * dump->triangles;
    float *vertices = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                              3 * sizeof(float), corners);
    uint32_t *index = rtcSetNewGeometryBuffer(mesh, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(uint32_t), dump->triangles);
    memcpy(vertices, dump->corners, 3 * corners * sizeof(float));
    for (uint32_t k = 0; k < corners; k++) index[k] = k;
    rtcSetGeometryBuildQuality(mesh, RTC_BUILD_QUALITY_HIGH);
    rtcCommitGeometry(mesh);
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_HIGH);
    rtcAttachGeometry(scene, mesh);
    rtcReleaseGeometry(mesh);
    rtcCommitScene(scene);
    return scene;
}

// An answer that nobody reads is not computed: the count of hidden rays keeps every one alive.
static uint64_t single(RTCScene scene, const Dump *dump, uint32_t shooter, uint32_t first,
                       uint32_t end, uint8_t *hidden) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    const float *from = dump->centres + 3 * shooter;
    uint64_t count = 0;
    for (uint32_t k = first; k < end; k++) {
        struct RTCRay ray = {.org_x = from[0], .org_y = from[1], .org_z = from[2], .tnear = NEAR,
                             .dir_x = dump->x[k] - from[0], .dir_y = dump->y[k] - from[1],
                             .dir_z = dump->z[k] - from[2], .tfar = FAR, .mask = -1};
        rtcOccluded1(scene, &context, &ray);
        int blocked = ray.tfar < 0.0f;
        count += blocked;
        if (hidden) hidden[k] = blocked;
    }
    return count;
}

static uint64_t packets(RTCScene scene, const Dump *dump, uint32_t shooter, uint32_t first,
                        uint32_t end, uint8_t *hidden) {
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    const float *from = dump->centres + 3 * shooter;
    struct RTCRay16 ray;
    int valid[WIDE] __attribute__((aligned(64)));
    uint64_t count = 0;
    for (uint32_t k = first; k < end; k += WIDE) {
        for (int i = 0; i < WIDE; i++) {
            ray.org_x[i] = from[0];
            ray.org_y[i] = from[1];
            ray.org_z[i] = from[2];
            ray.dir_x[i] = dump->x[k + i] - from[0];
            ray.dir_y[i] = dump->y[k + i] - from[1];
            ray.dir_z[i] = dump->z[k + i] - from[2];
            ray.tnear[i] = NEAR;
            ray.tfar[i] = FAR;
            ray.time[i] = 0.0f;
            ray.mask[i] = -1;
            ray.id[i] = i;
            ray.flags[i] = 0;
            valid[i] = k + i < end ? -1 : 0;
        }
        rtcOccluded16(valid, scene, &context, &ray);
        for (uint32_t i = 0; i < WIDE && k + i < end; i++) {
            int blocked = ray.tfar[i] < 0.0f;
            count += blocked;
            if (hidden) hidden[k + i] = blocked;
        }
    }
    return count;
}

// Seconds for the whole log; tasks of all shots are shared among the threads.
static double timed(Trace trace, RTCScene scene, const Dump *dump, uint64_t *hidden) {
    uint32_t tasks = (dump->texels + TASK - 1) / TASK;
    uint64_t sum = 0;
    double start = omp_get_wtime();
#pragma omp parallel for schedule(dynamic, 4) reduction(+ : sum)
    for (uint64_t k = 0; k < (uint64_t)dump->shots * tasks; k++) {
        uint32_t first = k % tasks * TASK;
        uint32_t end = first + TASK < dump->texels ? first + TASK : dump->texels;
        sum += trace(scene, dump, dump->log[k / tasks], first, end, NULL);
    }
    *hidden = sum;
    return omp_get_wtime() - start;
}

// Share of the rays between fronts that face each other whose answer is not ours.
static double unlike(Trace trace, RTCScene scene, const Dump *dump) {
    uint64_t facing = 0, differing = 0;
#pragma omp parallel for schedule(dynamic) reduction(+ : facing, differing)
    for (uint32_t s = 0; s < dump->shooters; s++) {
        uint8_t *hidden = need(malloc(dump->texels));
        trace(scene, dump, s, 0, dump->texels, hidden);
        const uint8_t *ours = dump->answers + (size_t)s * dump->texels;
        for (uint32_t k = 0; k < dump->texels; k++) {
            if (ours[k] > 1) continue;
            facing++;
            differing += (ours[k] == 1) == (hidden[k] == 1);
        }
        free(hidden);
    }
    return facing ? (double)differing / (double)facing : 0.0;
}

static void report(const char *name, Trace trace, RTCScene scene, const Dump *dump) {
    uint64_t hidden;
    double seconds = timed(trace, scene, dump, &hidden);
    double rays = (double)dump->shots * dump->texels;
    printf(", \"%s\": { \"rays\": %.0f, \"seconds\": %.6f, \"mrays_per_second\": %.3f, "
           "\"hidden\": %.6f, \"unlike_ours\": %.8f }",
           name, rays, seconds, rays / seconds * 1e-6, (double)hidden / rays,
           unlike(trace, scene, dump));
}

int main(int count, char **arguments) {
    if (count < 2) {
        fprintf(stderr, "usage: embree_rays FILE [THREADS]\n");
        return 2;
    }
    int threads = count > 2 ? atoi(arguments[2]) : 2;
    // Embree's manual asks for this on every thread that traces.
#pragma omp parallel num_threads(threads)
    {
        _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
        _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    }
    omp_set_num_threads(threads);
    Dump dump = read_dump(arguments[1]);
    RTCDevice device = rtcNewDevice(NULL);
    RTCScene scene = build(device, &dump);
    printf("{ \"embree\": \"%s\", \"threads\": %d, \"triangles\": %u, "
           "\"native_packets_of_16\": %s",
           RTC_VERSION_STRING, threads, dump.triangles,
           rtcGetDeviceProperty(device, RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED) ? "true"
                                                                                  : "false");
    report("single", single, scene, &dump);
    report("packets", packets, scene, &dump);
    printf(" }\n");
    return 0;
}
