// Some rows of the table of particles, passed on without a copy of the table.
#pragma once

#include <span>
#include <vector>

#include "sim/state/particles.h"

namespace thixo {

/// Particles in their order: all of a table, or those of some rows. The table and the list of rows must outlive it.
/// Member k is the particle row(k).
class ParticleRows {
  public:
    /// The particles `rows`, which ascend; without a list, all.
    ParticleRows(const Particles& table, const std::vector<Index>* rows = nullptr) : table_(table), rows_(rows) {}

    const Particles& table() const { return table_; }
    std::size_t size() const { return rows_ ? rows_->size() : table_.size(); }
    Index row(std::size_t member) const { return rows_ ? (*rows_)[member] : static_cast<Index>(member); }

    /// An array of the table, by member. `scratch` holds it where not all particles are members.
    template <class T>
    std::span<const T> values(const std::vector<T>& array, std::vector<T>& scratch) const {
        if (!rows_) return array;
        scratch.clear();
        scratch.reserve(size());
        for (const Index row : *rows_) scratch.push_back(array[row]);
        return scratch;
    }

  private:
    const Particles& table_;
    const std::vector<Index>* rows_;
};

}  // namespace thixo
