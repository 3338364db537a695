#include "sim/stage/checkpoint.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <functional>

#include "pipeline/base/error.h"
#include "pipeline/base/log.h"
#include "pipeline/contract/atomic_file.h"
#include "pipeline/contract/hash.h"
#include "sim/bonds/members.h"
#include "sim/fracture/fragments.h"
#include "sim/phase/phases.h"

namespace thixo {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kMagic = "THIXOCKP";
constexpr std::size_t kHashLength = 32;
constexpr int kKept = 2;
constexpr const char* kFolder = "checkpoint";
constexpr std::string_view kName = "checkpoint.", kRefusedName = "refused.";

class Writer {
  public:
    template <class T>
    void value(const char*, const T& v) {
        bytes_.append(reinterpret_cast<const char*>(&v), sizeof v);
    }
    void text(const char* name, const std::string& t) {
        value(name, static_cast<std::uint64_t>(t.size()));
        bytes_ += t;
    }
    template <class T>
    void array(const char* name, const std::vector<T>& a) {
        text(name, name);
        value(name, static_cast<std::uint32_t>(sizeof(T)));
        value(name, static_cast<std::uint64_t>(a.size()));
        bytes_.append(reinterpret_cast<const char*>(a.data()), a.size() * sizeof(T));
    }
    std::string& bytes() { return bytes_; }

  private:
    std::string bytes_;
};

class Reader {
  public:
    Reader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}
    template <class T>
    void value(const char* name, T& v) {
        std::memcpy(static_cast<void*>(&v), take(name, sizeof v), sizeof v);
    }
    void text(const char* name, std::string& t) {
        std::uint64_t length = 0;
        value(name, length);
        t.assign(take(name, length), length);
    }
    template <class T>
    void array(const char* name, std::vector<T>& a) {
        std::string stored;
        text(name, stored);
        std::uint32_t size = 0;
        std::uint64_t count = 0;
        value(name, size);
        value(name, count);
        if (stored != name || size != sizeof(T) || count > bytes_.size() / sizeof(T))
            throw CacheError("{}: holds '{}' where '{}' is expected", file_, stored, name);
        a.resize(count);
        std::memcpy(static_cast<void*>(a.data()), take(name, count * sizeof(T)), count * sizeof(T));
    }
    bool at_end() const { return bytes_.empty(); }

  private:
    const char* take(const char* name, std::uint64_t length) {
        if (length > bytes_.size()) throw CacheError("{}: ends within '{}'", file_, name);
        const char* at = bytes_.data();
        bytes_.remove_prefix(length);
        return at;
    }
    std::string_view bytes_;
    const std::string& file_;
};

constexpr std::uint64_t kMostRecords = 1u << 28;

/// What follows from tables that have just been read: numbers of elements, shapes and samples of bodies, weights of
/// surfels.
void rebind(Simulation& s) {
    Solids& solids = s.solids;
    solids.element_of.clear();
    for (Index i = 0; i < solids.elements.size(); ++i) number_element(solids.elements.id[i], i, solids);
    solids.softening.flow.plastic.resize(solids.elements.size());
    for (SolidBody& body : solids.bodies) {
        if (body.scene_shape) continue;
        body.shape.reset();
    }
    s.embedded.begin.assign(s.embedded.size() + 1, 0);
    s.embedded.weight.clear();
    bind_matter(std::vector<std::uint8_t>(solids.bodies.size(), 1), matter_of(s));
}

/// What of a body is state.
template <class Stream, class B>
void visit_body(Stream& stream, B& body) {
    stream.value("body.skin", body.skin);
    stream.value("body.refrozen", body.refrozen);
    stream.value("body.turn", body.turn);
    stream.value("body.place", body.place);
}

/// What of a body the scene tells, unless bodies have split or elements have come or gone.
template <class Stream, class B>
void visit_altered_body(Stream& stream, B& body) {
    stream.value("body.id", body.id);
    stream.value("body.parent", body.parent);
    stream.value("body.source", body.source);
    stream.value("body.material", body.material);
    stream.value("body.origin", body.origin);
    stream.value("body.scene_shape", body.scene_shape);
    stream.value("body.typical", body.typical);
    stream.value("body.lightest", body.lightest);
    stream.array("body.elements", body.elements);
    stream.array("body.cuts", body.cuts);
}

/// Records field by field: the bytes between fields are nobody's, and no two runs need have the same there.
template <class Stream, class Records, class... Field>
void visit_fields(Stream& stream, const char* name, Records& records, Field... field) {
    std::uint64_t count = records.size();
    stream.value(name, count);
    if constexpr (!std::is_const_v<Records>) {
        if (count > kMostRecords) throw CacheError("a checkpoint has {} records of '{}'", count, name);
        records.resize(count);
    }
    for (auto& record : records) (stream.value(name, record.*field), ...);
}

template <class Stream, class S>
void visit_bonds(Stream& stream, S& bonds) {
    stream.array("bonds.begin", bonds.begin);
    stream.array("bonds.neighbour", bonds.neighbour);
    stream.array("bonds.weight", bonds.weight);
    stream.array("bonds.weight_back", bonds.weight_back);
    stream.array("bonds.base", bonds.base);
    stream.array("bonds.base_back", bonds.base_back);
    stream.array("bonds.visibility", bonds.visibility);
    visit_fields(stream, "bonds.moment", bonds.moment, &RestMoment::inverse, &RestMoment::first, &RestMoment::trace,
                 &RestMoment::full);
    visit_fields(stream, "bonds.flat", bonds.flat, &std::pair<Index, Symmetric>::first,
                 &std::pair<Index, Symmetric>::second);
    if constexpr (!std::is_const_v<S>) bonds.changed();
}

/// Tables whose rows are no longer those that the scene makes.
template <class Stream, class S>
void visit_altered(Stream& stream, S& s) {
    auto& solids = s.solids;
    constexpr bool kReads = !std::is_const_v<S>;
    stream.value("next_body", solids.next_body);
    std::uint64_t count = solids.bodies.size();
    stream.value("bodies", count);
    if constexpr (kReads) {
        if (count > kMostRecords) throw CacheError("a checkpoint has {} bodies", count);
        solids.bodies.resize(count);
    }
    for (auto& body : solids.bodies) visit_altered_body(stream, body);
    for (auto& handle : solids.handles) {
        stream.array("handle.elements", handle.elements);
        stream.value("handle.mass", handle.mass);
    }
    for_each_array_of(Life::made, solids.elements, [&](const char* name, auto& array) { stream.array(name, array); });
    visit_bonds(stream, solids.elements.bonds);
    for_each_array(s.embedded, [&](const char* name, auto& array) { stream.array(name, array); });
    visit_fields(stream, "embedded.families", s.embedded.families, &SurfelFamily::first, &SurfelFamily::base,
                 &SurfelFamily::shift);
    if constexpr (kReads) rebind(s);
}

template <class Stream, class S>
void visit_solids(Stream& stream, S& s) {
    constexpr bool kReads = !std::is_const_v<S>;
    for (auto& body : s.bodies) visit_body(stream, body);
    for (auto& handle : s.handles) stream.array("solid.anchor", handle.anchor);
    stream.value("solid.last_dt", s.last_dt);
    stream.value("solid.stretch2", s.stretch2);
    for_each_array_of(Life::state, s.elements, [&](const char* name, auto& array) { stream.array(name, array); });
    for_each_array(s.contacts.nodes, [&](const char* name, auto& array) { stream.array(name, array); });
    if (!s.softening.any) return;
    stream.array("solid.rest", s.elements.rest);
    stream.array("solid.depth", s.elements.depth);
    if constexpr (kReads) {
        for (auto& body : s.bodies)
            if (body.refrozen) body.shape.reset();
        find_refrozen_neighbours(s);
    }
    // Rates are those found with the bonds of that time.
    stream.array("solid.laws", s.laws);
    stream.array("solid.rates", s.rates);
    bool current = s.rates_version == s.elements.bonds.version;
    stream.value("solid.rates_current", current);
    if constexpr (kReads) s.rates_version = current ? s.elements.bonds.version : 0;
    stream.array("solid.flow", s.softening.flow.plastic);
}

/// One list of what a checkpoint holds, for writing (S const) and reading.
template <class Stream, class S>
void visit_state(Stream& stream, S& s) {
    stream.value("frame", s.clock.frame);
    stream.value("step", s.clock.step);
    stream.value("time", s.clock.time);
    stream.value("last_dt", s.clock.last_dt);
    stream.value("next_id", s.next_id);
    for (auto& e : s.emitters) {
        stream.value("layer", e.layer);
        stream.value("next", e.next);
        stream.value("due", e.due);
        stream.value("blocked", e.blocked);
        stream.value("pushing", e.pushing);
    }
    for_each_array(s.particles, [&](const char* name, auto& array) { stream.array(name, array); });
    stream.value("altered", s.solids.altered);
    if (s.solids.altered) visit_altered(stream, s);
    if constexpr (!std::is_const_v<S>) {
        adopt_particles(s.problem.scene, s.problem.smoothing, s.particles, s.solids);
        locate_particles(s.particles, s.solids);
    }
    if (!s.solids.empty()) visit_solids(stream, s.solids);
    if (!s.solids.empty()) {
        stream.value("mixed.next_id", s.mixed_surface.animated.next_id);
        stream.array("mixed.lift", s.mixed_surface.animated.lift);
        stream.value("mixed.unmeasured", s.mixed_surface.animated.unmeasured);
        for_each_array(s.mixed_surface.animated, [&](const char* name, auto& array) { stream.array(name, array); });
        for_each_array(s.mixed_surface.zombies, [&](const char* name, auto& array) { stream.array(name, array); });
        for_each_array(s.mixed_surface.refrozen, [&](const char* name, auto& array) { stream.array(name, array); });
    }
    stream.value("surface.next_id", s.surface.next_id);
    stream.array("surface.lift", s.surface.lift);
    stream.value("surface.unmeasured", s.surface.unmeasured);
    for_each_array(s.surface, [&](const char* name, auto& array) { stream.array(name, array); });
}

fs::path folder_of(const fs::path& out) { return out / kFolder; }
fs::path file_of(const fs::path& out, int frame) { return folder_of(out) / fmt::format("{}{:04}.bin", kName, frame); }

/// The frame of a checkpoint by the name of its file, or -1.
int frame_of(const std::string& name) {
    constexpr std::string_view tail = ".bin";
    if (!name.starts_with(kName) || !name.ends_with(tail) || name.size() <= kName.size() + tail.size()) return -1;
    const char *first = name.data() + kName.size(), *last = name.data() + name.size() - tail.size();
    int frame = -1;
    const auto [end, error] = std::from_chars(first, last, frame);
    return error == std::errc() && end == last ? frame : -1;
}

bool is_own(const fs::path& file) { return starts_with(file, kMagic); }

/// Gives a file that is no usable checkpoint a name that no run reads: it must not count among those that are kept.
void set_aside(const fs::path& out, int frame) {
    fs::path aside;
    int number = 0;
    std::error_code error;
    do aside = folder_of(out) / fmt::format("{}{:04}.{}.bin", kRefusedName, frame, ++number);
    while (fs::exists(fs::symlink_status(aside, error)));
    fs::rename(file_of(out, frame), aside, error);
    if (error) throw ResourceError("cannot rename '{}': {}", file_of(out, frame).string(), error.message());
}

}  // namespace

std::string print_checkpoint(const Simulation& s, const std::string& simulation_hash) {
    Writer w;
    w.bytes() = kMagic;
    w.value("format", kCheckpointFormat);
    w.value("precision", static_cast<std::uint32_t>(sizeof(Real)));
    w.text("hash", simulation_hash);
    w.value("emitters", static_cast<std::uint64_t>(s.emitters.size()));
    visit_state(w, s);
    w.bytes() += hash_hex(w.bytes());
    return std::move(w.bytes());
}

void parse_checkpoint(std::string_view bytes, const std::string& file, const std::string& simulation_hash,
                      Simulation& s) {
    if (bytes.size() < kMagic.size() + kHashLength || bytes.substr(0, kMagic.size()) != kMagic)
        throw CacheError("{}: is not a checkpoint", file);
    const std::string_view body = bytes.substr(0, bytes.size() - kHashLength);
    if (!ends_with_checksum(bytes)) throw CacheError("{}: is damaged, its checksum differs", file);
    Reader r(body.substr(kMagic.size()), file);
    std::uint32_t format = 0, precision = 0;
    std::uint64_t emitters = 0;
    std::string hash;
    r.value("format", format);
    if (format != kCheckpointFormat)
        throw CacheError("{}: has format {}, this program reads {}", file, format, kCheckpointFormat);
    r.value("precision", precision);
    if (precision != sizeof(Real)) throw CacheError("{}: was written in another precision", file);
    r.text("hash", hash);
    if (hash != simulation_hash) throw CacheError("{}: belongs to another scene", file);
    r.value("emitters", emitters);
    if (emitters != s.emitters.size())
        throw CacheError("{}: has {} emitters, the scene has {}", file, emitters, s.emitters.size());
    visit_state(r, s);
    if (!r.at_end()) throw CacheError("{}: is longer than its content", file);
    move_walls(s.walls, s.clock.time);
}

std::vector<int> list_checkpoints(const fs::path& out) {
    std::vector<int> frames;
    std::error_code missing;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_of(out), missing))
        if (const int frame = frame_of(entry.path().filename().string()); frame >= 0) frames.push_back(frame);
    std::sort(frames.begin(), frames.end(), std::greater<>());
    return frames;
}

void write_checkpoint(const fs::path& out, int frame, std::string_view bytes) {
    make_subfolder(out, kFolder);
    write_whole(file_of(out, frame), bytes);
    int kept = 0;
    for (const int other : list_checkpoints(out)) {
        const bool ahead = other > frame;  // the run will pass it again
        if (!is_own(file_of(out, other)) || (!ahead && ++kept <= kKept)) continue;
        std::error_code ignored;  // an old checkpoint that stays does no harm
        fs::remove(file_of(out, other), ignored);
    }
}

bool restore_checkpoint(const fs::path& out, int last, const std::string& simulation_hash, Simulation& s) {
    make_subfolder(out, kFolder);
    remove_stale_temporaries(folder_of(out));
    for (const int frame : list_checkpoints(out)) {
        if (frame > last) continue;
        const std::string name = file_of(out, frame).filename().string();
        const std::size_t untouched = s.particles.size();
        try {
            parse_checkpoint(read_inside(folder_of(out), name, UINT64_MAX), file_of(out, frame).string(),
                             simulation_hash, s);
            return true;
        } catch (const CacheError& e) {
            // All that can be wrong is found before the state is touched, but for a file made to deceive the checksum.
            THIXO_ASSERT(s.clock.step == 0 && s.particles.size() == untouched, "{} was read in part", name);
            log_warning("{}; set aside, going on from an earlier state", e.what());
            set_aside(out, frame);
        }
    }
    return false;
}

void remove_checkpoints(const fs::path& out) {
    for (const int frame : list_checkpoints(out)) {
        std::error_code ignored;  // another scene's checkpoint is refused by its hash
        if (is_own(file_of(out, frame)))
            fs::remove(file_of(out, frame), ignored);
        else
            set_aside(out, frame);
    }
}

}  // namespace thixo
