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
#include "sim/fracture/frozen.h"
#include "sim/phase/phases.h"
#include "sim/stage/checkpoint_check.h"

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
    template <class Records>
    void records(const char* name, const Records& list, std::size_t) {
        value(name, static_cast<std::uint64_t>(list.size()));
    }
    std::string& bytes() { return bytes_; }

  private:
    std::string bytes_;
};

class Reader {
  public:
    Reader(std::string_view bytes, const std::string& file, const Solids& at_start)
        : bytes_(bytes), file_(file), at_start_(at_start) {}
    template <class T>
    void value(const char* name, T& v) {
        std::memcpy(static_cast<void*>(&v), take(name, sizeof v), sizeof v);
    }
    void value(const char* name, bool& v) {
        const char byte = *take(name, 1);
        if (byte != 0 && byte != 1) throw CacheError("{}: '{}' is neither true nor false", file_, name);
        v = byte == 1;
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
        const char* from = take(name, count * sizeof(T));
        if (count > 0) std::memcpy(static_cast<void*>(a.data()), from, count * sizeof(T));
    }
    /// Makes room for as many records as follow, each of at least `least` bytes.
    template <class Records>
    void records(const char* name, Records& list, std::size_t least) {
        std::uint64_t count = 0;
        value(name, count);
        if (count > bytes_.size() / least) throw CacheError("{}: ends within '{}'", file_, name);
        list.resize(count);
    }
    bool at_end() const { return bytes_.empty(); }
    const std::string& file() const { return file_; }
    /// The solids as the scene makes them.
    const Solids& at_start() const { return at_start_; }

  private:
    const char* take(const char* name, std::uint64_t length) {
        if (length > bytes_.size()) throw CacheError("{}: ends within '{}'", file_, name);
        const char* at = bytes_.data();
        bytes_.remove_prefix(length);
        return at;
    }
    std::string_view bytes_;
    const std::string& file_;
    const Solids& at_start_;
};

/// What follows from tables that have just been read: numbers of elements, shapes and samples of bodies, weights of
/// surfels.
void rebind(Simulation& sim) {
    Solids& solids = sim.solids;
    solids.element_of.clear();
    for (Index i = 0; i < solids.elements.size(); ++i) number_element(solids.elements.id[i], i, solids);
    solids.softening.flow.plastic.resize(solids.elements.size());
    for (SolidBody& body : solids.bodies)
        if (!body.scene_shape || body.refrozen) body.shape.reset();
    make_frozen_breaking(matter_of(sim));
    sim.crack_scratch.matter.clear();
    sim.embedded.begin.assign(sim.embedded.size() + 1, 0);
    sim.embedded.weight.clear();
    bind_matter(std::vector<std::uint8_t>(solids.bodies.size(), 1), matter_of(sim));
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
    stream.value("body.frame", body.frame);
    stream.value("body.material", body.material);
    stream.value("body.origin", body.origin);
    stream.value("body.scene_shape", body.scene_shape);
    stream.value("body.rigid", body.rigid);
    stream.value("body.typical", body.typical);
    stream.value("body.lightest", body.lightest);
    stream.array("body.elements", body.elements);
    stream.array("body.cuts", body.cuts);
}

/// Records field by field: the bytes between fields are nobody's, and no two runs need have the same there.
template <class Stream, class Records, class... Field>
void visit_fields(Stream& stream, const char* name, Records& records, Field... field) {
    using Record = typename Records::value_type;
    stream.records(name, records, (sizeof(std::declval<Record>().*field) + ...));
    for (auto& record : records) (stream.value(name, record.*field), ...);
}

template <class Stream, class S>
void visit_cracks(Stream& stream, S& cracks) {
    visit_fields(stream, "cracks", cracks.cracks, &Crack::source, &Crack::frame, &Crack::sheet, &Crack::strength);
    stream.records("fronts", cracks.fronts, sizeof(std::int32_t));
    for (auto& front : cracks.fronts) {
        stream.value("front.crack", front.crack);
        stream.value("front.closed", front.closed);
        visit_fields(stream, "front.nodes", front.nodes, &CrackNode::place, &CrackNode::advance, &CrackNode::heading,
                     &CrackNode::vertex, &CrackNode::state);
    }
    stream.array("cracks.vertex", cracks.vertex);
    for_each_array(cracks.triangles, [&](const char* name, auto& array) { stream.array(name, array); });
    for_each_array(cracks.crossings, [&](const char* name, auto& array) { stream.array(name, array); });
}

template <class Stream, class S>
void visit_bonds(Stream& stream, S& bonds) {
    THIXO_ASSERT(!bonds.wrap(), "bonds across periodic faces follow from the scene, and are not stored");
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
void visit_altered(Stream& stream, S& state) {
    auto& solids = state.solids;
    stream.value("next_body", solids.next_body);
    stream.records("bodies", solids.bodies, sizeof(std::int32_t));
    for (auto& body : solids.bodies) {
        visit_altered_body(stream, body);
        visit_body(stream, body);
    }
    for (auto& handle : solids.handles) {
        stream.array("handle.elements", handle.elements);
        stream.value("handle.mass", handle.mass);
    }
    for_each_array_of(Life::made, solids.elements, [&](const char* name, auto& array) { stream.array(name, array); });
    visit_bonds(stream, solids.elements.bonds);
    visit_cracks(stream, solids.cracks);
    for_each_array(state.embedded, [&](const char* name, auto& array) { stream.array(name, array); });
    stream.value("embedded.families_made", state.embedded.families_made);
    visit_fields(stream, "embedded.families", state.embedded.families, &SurfelFamily::first, &SurfelFamily::base,
                 &SurfelFamily::shift);
}

/// What of breaking solids is state. Rates may be those of bonds of a few steps before.
template <class Stream, class S>
void visit_breaking(Stream& stream, S& solids) {
    auto& bonds = solids.elements.bonds;
    stream.value("cracks.step", solids.cracks.step);
    stream.value("cracks.load", solids.cracks.load);
    stream.array("cracks.laws", solids.laws);
    stream.array("cracks.rates", solids.rates);
    stream.value("cracks.weakened", bonds.weakened);
    for (auto& blade : solids.blades) {
        stream.value("blade.crack", blade.crack);
        stream.array("blade.row", blade.row);
        stream.array("blade.vertex", blade.vertex);
        stream.array("blade.rim", blade.rim);
        for (auto& side : blade.side) stream.array("blade.side", side);
    }
    bool follow = solids.rates_version + bonds.weakened == bonds.version;
    stream.value("cracks.rates_follow", follow);
    if constexpr (!std::is_const_v<S>) solids.rates_version = follow ? bonds.version - bonds.weakened : 0;
}

template <class Stream, class S>
void visit_solids(Stream& stream, S& solids) {
    if (!solids.altered)
        for (auto& body : solids.bodies) visit_body(stream, body);
    for (auto& handle : solids.handles) stream.array("solid.anchor", handle.anchor);
    stream.value("solid.last_dt", solids.last_dt);
    stream.value("solid.stretch2", solids.stretch2);
    stream.value("solid.stiffening", solids.stiffening);
    if (solids.elements.breaks) visit_breaking(stream, solids);
    for_each_array_of(Life::state, solids.elements, [&](const char* name, auto& array) { stream.array(name, array); });
    for_each_array(solids.contacts.nodes, [&](const char* name, auto& array) { stream.array(name, array); });
    if (!solids.softening.any) return;
    stream.array("solid.rest", solids.elements.rest);
    stream.array("solid.depth", solids.elements.depth);
    // Rates are those found with the bonds of that time.
    stream.array("solid.laws", solids.laws);
    stream.array("solid.rates", solids.rates);
    bool current = solids.rates_version == solids.elements.bonds.version;
    stream.value("solid.rates_current", current);
    if constexpr (!std::is_const_v<S>) solids.rates_version = current ? solids.elements.bonds.version : 0;
    stream.array("solid.flow", solids.softening.flow.plastic);
}

/// What follows from the state of solids that has just been read: the neighbours of bodies that have frozen anew.
void find_refrozen(Solids& solids) {
    for (SolidBody& body : solids.bodies)
        if (body.refrozen) body.shape.reset();
    const bool current = solids.rates_version == solids.elements.bonds.version;
    find_refrozen_neighbours(solids);
    if (current) solids.rates_version = solids.elements.bonds.version;
}

/// One list of what a checkpoint holds, for writing (S const) and reading. What is read is checked before anything
/// follows from it.
template <class Stream, class S>
void visit_state(Stream& stream, S& state) {
    constexpr bool kReads = !std::is_const_v<S>;
    stream.value("frame", state.clock.frame);
    stream.value("step", state.clock.step);
    stream.value("time", state.clock.time);
    stream.value("last_dt", state.clock.last_dt);
    stream.value("next_id", state.next_id);
    for (auto& e : state.emitters) {
        stream.value("layer", e.layer);
        stream.value("next", e.next);
        stream.value("due", e.due);
        stream.value("blocked", e.blocked);
        stream.value("pushing", e.pushing);
    }
    for_each_array(state.particles, [&](const char* name, auto& array) { stream.array(name, array); });
    if constexpr (kReads) {
        check_clock(state, stream.file());
        check_particles(state, stream.file());
    }
    stream.value("altered", state.solids.altered);
    if (state.solids.altered) visit_altered(stream, state);
    if constexpr (kReads) {
        if (state.solids.altered) {
            check_altered(state, stream.at_start(), stream.file());
            rebind(state);
        }
        adopt_particles(state.problem.materials, state.problem.smoothing, state.particles, state.solids);
        locate_particles(state.particles, state.solids);
    }
    if (!state.solids.empty()) visit_solids(stream, state.solids);
    if constexpr (kReads) {
        check_solids(state, stream.file());
        // Bonds of matter that has been altered are stored, and not found anew.
        if (state.solids.softening.any && !state.solids.altered) find_refrozen(state.solids);
    }
    if (!state.solids.empty()) {
        stream.value("mixed.next_id", state.mixed_surface.animated.next_id);
        stream.array("mixed.lift", state.mixed_surface.animated.lift);
        stream.value("mixed.unmeasured", state.mixed_surface.animated.unmeasured);
        for_each_array(state.mixed_surface.animated, [&](const char* name, auto& array) { stream.array(name, array); });
        for_each_array(state.mixed_surface.zombies, [&](const char* name, auto& array) { stream.array(name, array); });
        for_each_array(state.mixed_surface.refrozen, [&](const char* name, auto& array) { stream.array(name, array); });
    }
    stream.value("surface.next_id", state.surface.next_id);
    stream.array("surface.lift", state.surface.lift);
    stream.value("surface.unmeasured", state.surface.unmeasured);
    for_each_array(state.surface, [&](const char* name, auto& array) { stream.array(name, array); });
    if constexpr (kReads) check_surfaces(state, stream.file());
}

/// All that reading a checkpoint writes.
struct State {
    Clock clock;
    std::int64_t next_id;
    std::vector<EmitterState> emitters;
    Particles particles;
    Solids solids;
    EmbeddedSurface embedded;
    MixedSurface mixed_surface;
    SurfaceState surface;
};
State state_of(const Simulation& sim) {
    return {sim.clock,  sim.next_id,  sim.emitters,      sim.particles,
            sim.solids, sim.embedded, sim.mixed_surface, sim.surface};
}
void put_back(State&& from, Simulation& sim) {
    sim.clock = from.clock;
    sim.next_id = from.next_id;
    sim.emitters = std::move(from.emitters);
    sim.particles = std::move(from.particles);
    sim.solids = std::move(from.solids);
    sim.embedded = std::move(from.embedded);
    sim.mixed_surface = std::move(from.mixed_surface);
    sim.surface = std::move(from.surface);
    sim.crack_scratch.matter.clear();  // it points into what has just been replaced
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

/// The body of a checkpoint, behind its magic word and before its checksum.
std::string_view body_of(std::string_view bytes, const std::string& file) {
    if (bytes.size() < kMagic.size() + kHashLength || bytes.substr(0, kMagic.size()) != kMagic)
        throw CacheError("{}: is not a checkpoint", file);
    if (!ends_with_checksum(bytes)) throw CacheError("{}: is damaged, its checksum differs", file);
    return bytes.substr(kMagic.size(), bytes.size() - kMagic.size() - kHashLength);
}

void read_header(const std::string& simulation_hash, std::size_t emitters, Reader& r) {
    std::uint32_t format = 0, precision = 0;
    std::uint64_t stored_emitters = 0;
    std::string hash;
    r.value("format", format);
    if (format != kCheckpointFormat)
        throw CacheError("{}: has format {}, this program reads {}", r.file(), format, kCheckpointFormat);
    r.value("precision", precision);
    if (precision != sizeof(Real)) throw CacheError("{}: was written in another precision", r.file());
    r.text("hash", hash);
    if (hash != simulation_hash) throw CacheError("{}: belongs to another scene", r.file());
    r.value("emitters", stored_emitters);
    if (stored_emitters != emitters)
        throw CacheError("{}: has {} emitters, the scene has {}", r.file(), stored_emitters, emitters);
}

/// parse_checkpoint, of this frame where one is given.
void read_checkpoint(std::string_view bytes, const std::string& file, const std::string& simulation_hash,
                     std::optional<int> frame, Simulation& sim) {
    const std::string_view body = body_of(bytes, file);
    State before = state_of(sim);
    try {
        Reader r(body, file, before.solids);
        read_header(simulation_hash, sim.emitters.size(), r);
        visit_state(r, sim);
        if (!r.at_end()) throw CacheError("{}: is longer than its content", file);
        if (frame && sim.clock.frame != *frame) throw CacheError("{}: holds frame {}", file, sim.clock.frame);
    } catch (const InputError& e) {  // surfels that are no shape of a piece, for one
        put_back(std::move(before), sim);
        throw CacheError("{}: {}", file, e.what());
    } catch (...) {
        put_back(std::move(before), sim);
        throw;
    }
    move_walls(sim.walls, sim.clock.time);
}

}  // namespace

std::string print_checkpoint(const Simulation& sim, const std::string& simulation_hash) {
    Writer w;
    w.bytes() = kMagic;
    w.value("format", kCheckpointFormat);
    w.value("precision", static_cast<std::uint32_t>(sizeof(Real)));
    w.text("hash", simulation_hash);
    w.value("emitters", static_cast<std::uint64_t>(sim.emitters.size()));
    visit_state(w, sim);
    w.bytes() += hash_hex(w.bytes());
    return std::move(w.bytes());
}

void parse_checkpoint(std::string_view bytes, const std::string& file, const std::string& simulation_hash,
                      Simulation& sim) {
    read_checkpoint(bytes, file, simulation_hash, {}, sim);
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

bool restore_checkpoint(const fs::path& out, int last, const std::string& simulation_hash, Simulation& sim) {
    make_subfolder(out, kFolder);
    remove_stale_temporaries(folder_of(out));
    for (const int frame : list_checkpoints(out)) {
        if (frame > last) continue;
        const std::string name = file_of(out, frame).filename().string();
        try {
            read_checkpoint(read_inside(folder_of(out), name, UINT64_MAX), file_of(out, frame).string(),
                            simulation_hash, frame, sim);
            return true;
        } catch (const CacheError& e) {
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
