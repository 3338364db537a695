#include "pipeline/check/compare_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <numeric>
#include <optional>
#include <type_traits>

namespace thixo {

namespace {

bool equal_bits(double a, double b) { return std::bit_cast<std::uint64_t>(a) == std::bit_cast<std::uint64_t>(b); }

template <std::size_t N>
bool equal_bits(const std::array<double, N>& a, const std::array<double, N>& b) {
    return std::memcmp(a.data(), b.data(), sizeof a) == 0;
}

bool equal(const TrimNode& a, const TrimNode& b) {
    const auto& [op, sheet, parts, reach] = a;
    return op == b.op && sheet == b.sheet && reach == b.reach &&
           std::equal(parts.begin(), parts.end(), b.parts.begin(), b.parts.end(),
                      [](const TrimNode& x, const TrimNode& y) { return equal(x, y); });
}

bool equal(const std::optional<TrimNode>& a, const std::optional<TrimNode>& b) {
    return a && b ? equal(*a, *b) : a.has_value() == b.has_value();
}

struct FieldResult {
    const char* name;
    bool equal;
};

// Each structured binding below names all fields of its struct. A field that is added therefore fails to compile here
// until it is compared.

std::vector<FieldResult> compare_fields(const FrameBody& a, const FrameBody& b) {
    const auto& [id, parent, name, material, trim] = a;
    return {{"id", id == b.id},
            {"parent", parent == b.parent},
            {"name", name == b.name},
            {"material", material == b.material},
            {"trim tree", equal(trim, b.trim)}};
}

std::vector<FieldResult> compare_fields(const FrameObstacle& a, const FrameObstacle& b) {
    const auto& [name, look, asset, transform, velocity, angular_velocity] = a;
    return {{"name", name == b.name},
            {"look", look == b.look},
            {"asset", asset == b.asset},
            {"transform", equal_bits(transform, b.transform)},
            {"velocity", equal_bits(velocity, b.velocity)},
            {"angular velocity", equal_bits(angular_velocity, b.angular_velocity)}};
}

template <class T>
void compare_lists(const char* what, const std::vector<T>& a, const std::vector<T>& b,
                   std::vector<std::string>& problems) {
    if (a.size() != b.size()) {
        problems.push_back(fmt::format("{} {}, the reference {}", a.size(), what, b.size()));
        return;
    }
    for (std::size_t i = 0; i < a.size(); ++i)
        for (const FieldResult& field : compare_fields(a[i], b[i]))
            if (!field.equal) problems.push_back(fmt::format("{}: '{}' differs in {}", what, a[i].name, field.name));
}

void compare_numbers(const char* what, double a, double b, std::vector<std::string>& problems) {
    if (!std::isfinite(a)) problems.push_back(fmt::format("{} is not finite", what));
    if (!equal_bits(a, b)) problems.push_back(fmt::format("{} is {}, the reference {}", what, a, b));
}

void compare_vectors(const char* what, const std::array<double, 3>& a, const std::array<double, 3>& b,
                     std::vector<std::string>& problems) {
    for (std::size_t k = 0; k < 3; ++k)
        compare_numbers(fmt::format("{}.{}", what, "xyz"[k]).c_str(), a[k], b[k], problems);
}

void compare_counts(const char* what, std::int64_t a, std::int64_t b, std::vector<std::string>& problems) {
    if (a != b) problems.push_back(fmt::format("{} {}, the reference {}", a, what, b));
}

void compare_totals(const FrameTotals& a, const FrameTotals& b, std::vector<std::string>& problems) {
    const auto& [mass, momentum, angular_momentum, kinetic_energy, potential_energy, particle_volume, surface_volume,
                 density_error, air, virtual_particles] = a;
    compare_numbers("mass", mass, b.mass, problems);
    compare_vectors("momentum", momentum, b.momentum, problems);
    compare_vectors("angular momentum", angular_momentum, b.angular_momentum, problems);
    compare_numbers("kinetic energy", kinetic_energy, b.kinetic_energy, problems);
    compare_numbers("potential energy", potential_energy, b.potential_energy, problems);
    compare_numbers("particle volume", particle_volume, b.particle_volume, problems);
    compare_numbers("surface volume", surface_volume, b.surface_volume, problems);
    compare_numbers("density error", density_error, b.density_error, problems);
    compare_counts("air particles", air, b.air, problems);
    compare_counts("virtual particles", virtual_particles, b.virtual_particles, problems);
}

// The order in which points are compared, and the number that names each in messages.
struct Order {
    std::vector<std::size_t> points;
    std::vector<std::int64_t> ids;
    bool by_id = false;
};

Order order_of(const PointSet& points) {
    Order order;
    order.points.resize(points.count);
    std::iota(order.points.begin(), order.points.end(), std::size_t(0));
    order.ids.resize(points.count);
    std::iota(order.ids.begin(), order.ids.end(), std::int64_t(0));
    const Attribute* a = points.find("id");
    if (!a) return order;
    if (const auto* wide = std::get_if<std::vector<std::int64_t>>(&a->data))
        order.ids = *wide;
    else if (const auto* narrow = std::get_if<std::vector<std::int32_t>>(&a->data))
        order.ids.assign(narrow->begin(), narrow->end());
    else
        return order;
    order.by_id = true;
    std::stable_sort(order.points.begin(), order.points.end(),
                     [&](std::size_t i, std::size_t j) { return order.ids[i] < order.ids[j]; });
    std::sort(order.ids.begin(), order.ids.end());
    return order;
}

// Largest difference of two values over their components. It is 0 where one is not finite: those are counted apart.
template <class T>
double distance(const T& a, const T& b) {
    if constexpr (std::is_same_v<T, Vec3f>) {
        const double d = (a.template cast<double>() - b.template cast<double>()).cwiseAbs().maxCoeff();
        return std::isfinite(d) ? d : 0;
    } else if constexpr (std::is_integral_v<T>) {
        return a < b ? static_cast<double>(b) - static_cast<double>(a)
                     : static_cast<double>(a) - static_cast<double>(b);
    } else {
        const double d = std::abs(static_cast<double>(a) - static_cast<double>(b));
        return std::isfinite(d) ? d : 0;
    }
}

template <class T>
bool finite(const T& x) {
    if constexpr (std::is_same_v<T, Vec3f>)
        return x.allFinite();
    else
        return std::isfinite(static_cast<double>(x));
}

template <class T>
void compare_values(const std::string& name, const std::vector<T>& a, const Order& order_a, const std::vector<T>& b,
                    const Order& order_b, FrameReport& report) {
    AttributeDifference d;
    d.name = name;
    std::size_t not_finite = 0;
    for (std::size_t i = 0; i < order_a.points.size(); ++i) {
        const T &x = a[order_a.points[i]], &y = b[order_b.points[i]];
        if (!finite(x) || !finite(y)) ++not_finite;
        if (std::memcmp(&x, &y, sizeof(T)) == 0) continue;
        const double difference = distance(x, y);
        if (d.different++ > 0 && difference <= d.max_abs) continue;
        d.max_abs = difference;
        d.worst_id = order_a.ids[i];
    }
    if (not_finite > 0) report.problems.push_back(fmt::format("{}: {} points are not finite", name, not_finite));
    if (d.different == 0) return;
    report.problems.push_back(fmt::format("{} differs", name));
    report.attributes.push_back(d);
}

// Whether the points of both sides can be paired.
bool pairs_up(const std::string& what, const Order& a, const Order& b, std::vector<std::string>& problems) {
    if (a.points.size() != b.points.size()) {
        problems.push_back(fmt::format("{} {}, the reference {}", a.points.size(), what, b.points.size()));
        return false;
    }
    if (a.by_id != b.by_id) return false;  // compare_points reports the attribute
    const auto [x, y] = std::mismatch(a.ids.begin(), a.ids.end(), b.ids.begin());
    if (x == a.ids.end()) return true;
    problems.push_back(fmt::format("{}: other ids, the first {} in place of {}", what, *x, *y));
    return false;
}

void compare_points(const std::string& what, const PointSet& a, const PointSet& b, FrameReport& report) {
    for (const int k : {0, 1, 2})
        compare_numbers(fmt::format("{}: origin.{}", what, "xyz"[k]).c_str(), a.origin[k], b.origin[k],
                        report.problems);
    const Order order_a = order_of(a), order_b = order_of(b);
    const bool paired = pairs_up(what, order_a, order_b, report.problems);
    for (const Attribute& other : b.attributes)
        if (!a.find(other.name)) report.problems.push_back(fmt::format("{}.{} is missing", what, other.name));
    for (const Attribute& attribute : a.attributes) {
        const std::string name = what + "." + attribute.name;
        const Attribute* other = b.find(attribute.name);
        if (!other)
            report.problems.push_back(fmt::format("{} is not in the reference", name));
        else if (other->data.index() != attribute.data.index())
            report.problems.push_back(fmt::format("{} has another type", name));
        else if (paired)
            std::visit(
                [&](const auto& values) {
                    compare_values(name, values, order_a, std::get<std::decay_t<decltype(values)>>(other->data),
                                   order_b, report);
                },
                attribute.data);
    }
}

}  // namespace

FrameReport compare_frames(const std::string& name, const Frame& a, const Frame& b) {
    FrameReport report;
    report.name = name;
    const auto& [number, time, spacing, particles, surfels, bodies, obstacles, fronts, totals, shortfalls] = a;
    if (number != b.number)
        report.problems.push_back(fmt::format("its number is {}, the reference {}", number, b.number));
    compare_numbers("time", time, b.time, report.problems);
    compare_numbers("spacing", spacing, b.spacing, report.problems);
    compare_lists("bodies", bodies, b.bodies, report.problems);
    compare_lists("obstacles", obstacles, b.obstacles, report.problems);
    if (!std::ranges::equal(fronts, b.fronts, [](const FrameFront& x, const FrameFront& y) {
            return x.closed == y.closed && x.nodes == y.nodes;
        }))
        report.problems.push_back("its list of fronts differs");
    compare_totals(totals, b.totals, report.problems);
    if (shortfalls != b.shortfalls) report.problems.push_back("its list of shortfalls differs");
    compare_points("particles", particles, b.particles, report);
    compare_points("surfels", surfels, b.surfels, report);
    return report;
}

}  // namespace thixo
