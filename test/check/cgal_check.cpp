/* test/check/cgal_check.cpp - the judge against CGAL's exact geometry. Built only where CGAL is
 * installed. Exit code 0: all agree.
 *
 * Pairs: CGAL constructs the intersection of two triangles with area exactly; whatever is not just
 * the shared vertex or edge counts. Meshes: CGAL's self-intersections of an indexed mesh. */
#include "tulle/check.h"

#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/self_intersections.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/intersections.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <set>
#include <utility>
#include <vector>

namespace {

using exact = CGAL::Exact_predicates_exact_constructions_kernel;
using inexact = CGAL::Exact_predicates_inexact_constructions_kernel;
using surface = CGAL::Surface_mesh<inexact::Point_3>;
using index_pair = std::pair<std::uint32_t, std::uint32_t>;

struct mesh {
    std::vector<double> positions;
    std::vector<std::uint32_t> triangles;
    tulle_mesh_view view() const {
        return {positions.data(), positions.size() / 3, triangles.data(), triangles.size() / 3};
    }
    template <class Point> Point point(std::uint32_t v) const {
        return Point(positions[3 * v], positions[3 * v + 1], positions[3 * v + 2]);
    }
};

std::set<index_pair> judge(const mesh &m, int &failures) {
    tulle_check_body body = {};
    body.mesh = m.view();
    tulle_check_result result;
    tulle_error error;
    std::set<index_pair> pairs;
    if (tulle_check_intersections(&body, 1, 1, &result, &error) != TULLE_OK) {
        std::fprintf(stderr, "judge: %s\n", error.message);
        failures++;
        return pairs;
    }
    for (std::size_t i = 0; i < result.pair_count; i++)
        pairs.insert({result.pairs[i].triangle_a, result.pairs[i].triangle_b});
    tulle_check_result_destroy(&result);
    return pairs;
}

/* Whether triangles 0 and 1 of the mesh meet outside their shared vertices, by construction. */
bool constructs_intersection(const mesh &m) {
    const std::uint32_t *const t = m.triangles.data();
    exact::Triangle_3 const a(m.point<exact::Point_3>(t[0]), m.point<exact::Point_3>(t[1]),
                              m.point<exact::Point_3>(t[2]));
    exact::Triangle_3 const b(m.point<exact::Point_3>(t[3]), m.point<exact::Point_3>(t[4]),
                              m.point<exact::Point_3>(t[5]));
    std::vector<exact::Point_3> shared;
    for (int i = 0; i < 3; i++)
        for (int j = 3; j < 6; j++)
            if (t[i] == t[j]) shared.push_back(m.point<exact::Point_3>(t[i]));
    auto const common = CGAL::intersection(a, b);
    if (!common) return false;
    if (shared.empty() || shared.size() == 3) return true;
    if (const auto *const point = boost::get<exact::Point_3>(&*common))
        return shared.size() == 1 && *point != shared[0];
    if (const auto *const segment = boost::get<exact::Segment_3>(&*common))
        return shared.size() == 1 || (*segment != exact::Segment_3(shared[0], shared[1]) &&
                                      *segment != exact::Segment_3(shared[1], shared[0]));
    return true;
}

int compare_pairs(int shared, int count) {
    std::mt19937_64 random(static_cast<unsigned>(40 + shared));
    int failures = 0, positive = 0, compared = 0;
    while (compared < count && failures < 10) {
        int const grid = 2 + compared % 4;
        mesh m;
        bool const is_flat = random() % 3 == 0;
        for (int i = 0; i < 18; i++)
            m.positions.push_back(
                is_flat && i % 3 == 1
                    ? 1.0
                    : static_cast<double>(random() % static_cast<unsigned>(grid)));
        m.triangles = {0, 1, 2, 3, 4, 5};
        for (int i = 0; i < shared; i++)
            m.triangles[static_cast<std::size_t>(5 - i)] = static_cast<std::uint32_t>(i);
        bool has_area = true;
        for (std::size_t t = 0; t < 2; t++)
            has_area =
                has_area && !CGAL::collinear(m.point<inexact::Point_3>(m.triangles[3 * t]),
                                             m.point<inexact::Point_3>(m.triangles[3 * t + 1]),
                                             m.point<inexact::Point_3>(m.triangles[3 * t + 2]));
        if (!has_area) continue;
        compared++;
        bool const expected = constructs_intersection(m);
        positive += expected;
        if (judge(m, failures).empty() != expected) continue;
        failures++;
        std::fprintf(stderr, "%d shared, pair %d: expected %d\n", shared, compared, expected);
        for (std::uint32_t v : m.triangles)
            std::fprintf(stderr, "  %u: %g %g %g\n", v, m.positions[3 * v], m.positions[3 * v + 1],
                         m.positions[3 * v + 2]);
    }
    std::printf("%d shared: %d pairs, %d intersect, %d differ\n", shared, compared, positive,
                failures);
    return failures;
}

/* A crumpled sheet: a grid of columns x columns with heights and places disturbed. */
mesh make_sheet(unsigned columns, double amount, double rounding, unsigned seed) {
    std::mt19937_64 random(seed);
    std::uniform_real_distribution<double> offset(-amount, amount);
    mesh m;
    for (unsigned j = 0; j < columns; j++)
        for (unsigned i = 0; i < columns; i++) {
            double const place[3] = {double(i), double(j), 0.0};
            for (double x : place) {
                double const moved = x + offset(random);
                m.positions.push_back(rounding > 0.0 ? rounding * std::floor(moved / rounding)
                                                     : moved);
            }
        }
    for (unsigned j = 0; j + 1 < columns; j++)
        for (unsigned i = 0; i + 1 < columns; i++) {
            std::uint32_t const a = j * columns + i, b = a + 1, c = a + columns, d = c + 1;
            m.triangles.insert(m.triangles.end(), {a, b, d, a, d, c});
        }
    return m;
}

/* CGAL takes no triangles without area, and no face that would make a vertex non-manifold: these
 * are left out on both sides. */
int compare_mesh(const mesh &whole, const char *name) {
    surface s;
    std::vector<surface::Vertex_index> vertices;
    for (std::uint32_t v = 0; v < whole.positions.size() / 3; v++)
        vertices.push_back(s.add_vertex(whole.point<inexact::Point_3>(v)));
    mesh m = {whole.positions, {}};
    for (std::size_t t = 0; t < whole.triangles.size(); t += 3) {
        const std::uint32_t *const v = &whole.triangles[t];
        if (CGAL::collinear(m.point<inexact::Point_3>(v[0]), m.point<inexact::Point_3>(v[1]),
                            m.point<inexact::Point_3>(v[2])))
            continue;
        if (s.add_face(vertices[v[0]], vertices[v[1]], vertices[v[2]]) == surface::null_face())
            continue;
        m.triangles.insert(m.triangles.end(), v, v + 3);
    }
    std::vector<std::pair<surface::Face_index, surface::Face_index>> found;
    CGAL::Polygon_mesh_processing::self_intersections(s, std::back_inserter(found));
    std::set<index_pair> expected;
    for (auto const &pair : found) {
        std::uint32_t const a = pair.first, b = pair.second;
        expected.insert({std::min(a, b), std::max(a, b)});
    }
    int failures = 0;
    std::set<index_pair> const got = judge(m, failures);
    if (got != expected) failures++;
    std::printf("%s: %zu triangles, judge finds %zu pairs, CGAL %zu\n", name,
                m.triangles.size() / 3, got.size(), expected.size());
    return failures;
}

} // namespace

int main() {
    int const factor = std::getenv("TULLE_TEST_LONG") ? 20 : 1;
    int failures = 0;
    failures += compare_pairs(0, 20000 * factor);
    failures += compare_pairs(1, 10000 * factor);
    failures += compare_pairs(2, 10000 * factor);
    for (unsigned seed = 0; seed < 3; seed++) {
        failures += compare_mesh(make_sheet(60, 0.35, 0.0, seed), "rough sheet");
        failures += compare_mesh(make_sheet(40, 2.0, 0.0, seed), "crumpled sheet");
        failures += compare_mesh(make_sheet(40, 4.0, 0.0, seed), "tangled sheet");
        failures += compare_mesh(make_sheet(40, 1.5, 0.5, seed), "sheet on a grid");
    }
    failures += compare_mesh(make_sheet(60, 0.0, 0.0, 0), "flat sheet");
    std::printf("%d failures\n", failures);
    return failures ? EXIT_FAILURE : EXIT_SUCCESS;
}
