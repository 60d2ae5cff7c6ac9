/* Embree's answers and times for rays that `cargo bench --bench traversal` sends through a pipe.
 *
 * Input, in the machine's byte order: number of vertices and their coordinates, number of triangles
 * and their corners, number of ray sets, and each set's number of rays and rays (origin, direction,
 * length: 7 floats). Then lines "ROBUST SET ANY" (0 or 1, number of the set, 0 or 1), each answered by
 * "SECONDS HITS": processor time of the thread, and how many rays hit something.
 */
#include <embree3/rtcore.h>
#include <math.h>
#include <pmmintrin.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct { float o[3], d[3], t_max; } Ray;
typedef struct { uint32_t count; Ray *rays; } Set;
typedef struct { float *vertices; uint32_t *triangles; uint32_t vertex_count, triangle_count; } Mesh;

static void fail(const char *what)
{
    fprintf(stderr, "embree_rays: %s\n", what);
    exit(2);
}

static void read_all(void *to, size_t size, size_t count)
{
    if (fread(to, size, count, stdin) != count) fail("input ends early");
}

static uint32_t read_count(void)
{
    uint32_t n;
    read_all(&n, sizeof n, 1);
    return n;
}

static void *room(size_t size, size_t count)
{
    /* Embree reads 16 bytes at the last vertex. */
    void *p = aligned_alloc(64, (size * count + 16 + 63) / 64 * 64);
    if (!p) fail("no memory");
    return p;
}

static RTCScene build(RTCDevice device, const Mesh *mesh, enum RTCSceneFlags flags)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                               mesh->vertices, 0, 12, mesh->vertex_count);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                               mesh->triangles, 0, 12, mesh->triangle_count);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcSetSceneFlags(scene, flags);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    rtcCommitScene(scene);
    if (rtcGetDeviceError(device) != RTC_ERROR_NONE) fail("Embree cannot build the scene");
    return scene;
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return t.tv_sec + 1e-9 * t.tv_nsec;
}

static void prepare(struct RTCRay *to, const Ray *ray)
{
    to->org_x = ray->o[0], to->org_y = ray->o[1], to->org_z = ray->o[2];
    to->dir_x = ray->d[0], to->dir_y = ray->d[1], to->dir_z = ray->d[2];
    to->tnear = 0, to->tfar = ray->t_max, to->time = 0;
    to->mask = 0xffffffff, to->id = 0, to->flags = 0;
}

static uint32_t closest(RTCScene scene, const Set *set)
{
    uint32_t hits = 0;
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint32_t i = 0; i < set->count; i++) {
        struct RTCRayHit query;
        prepare(&query.ray, &set->rays[i]);
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(scene, &context, &query);
        hits += query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }
    return hits;
}

static uint32_t any(RTCScene scene, const Set *set)
{
    uint32_t hits = 0;
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint32_t i = 0; i < set->count; i++) {
        struct RTCRay query;
        prepare(&query, &set->rays[i]);
        rtcOccluded1(scene, &context, &query);
        hits += query.tfar == -INFINITY;
    }
    return hits;
}

int main(void)
{
    /* As Embree's manual asks for. */
    _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
    _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
    Mesh mesh;
    mesh.vertex_count = read_count();
    mesh.vertices = room(12, mesh.vertex_count);
    read_all(mesh.vertices, 12, mesh.vertex_count);
    mesh.triangle_count = read_count();
    mesh.triangles = room(12, mesh.triangle_count);
    read_all(mesh.triangles, 12, mesh.triangle_count);
    uint32_t set_count = read_count();
    Set *sets = room(sizeof *sets, set_count);
    for (uint32_t i = 0; i < set_count; i++) {
        sets[i].count = read_count();
        sets[i].rays = room(sizeof(Ray), sets[i].count);
        read_all(sets[i].rays, sizeof(Ray), sets[i].count);
    }
    RTCDevice device = rtcNewDevice("threads=1");
    if (!device) fail("Embree does not start");
    RTCScene scenes[2] = {build(device, &mesh, RTC_SCENE_FLAG_NONE),
                          build(device, &mesh, RTC_SCENE_FLAG_ROBUST)};
    unsigned robust, set, query;
    while (scanf("%u %u %u", &robust, &set, &query) == 3) {
        if (robust > 1 || set >= set_count || query > 1) fail("no such question");
        double start = now();
        uint32_t hits = (query ? any : closest)(scenes[robust], &sets[set]);
        printf("%.9f %u\n", now() - start, hits);
        fflush(stdout);
    }
    return 0;
}
