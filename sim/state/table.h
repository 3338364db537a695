// Tables: structures of arrays, each with one list of its fields. Every operation on all arrays of a table uses that
// list: length, order, removal, checkpoint, the test of thread counts. No array can be forgotten.
#pragma once

#include <cstddef>
#include <cstring>
#include <type_traits>
#include <vector>

#include "pipeline/base/math.h"
#include "pipeline/base/parallel.h"

namespace thixo {

/// How long the values of a field live.
enum class Life {
    made,   // set when a row is made; part of a checkpoint where rows were made after set-up
    state,  // changes from step to step; part of every checkpoint
};

/// The field list of a table is a function found by argument-dependent lookup:
///     for_each_field(table, f)      calls f(name, life, array) for every array of the table
/// A group of fields that a scene does not need is left out of the list.
template <class Table, class F>
void for_each_array(Table& table, F&& f) {
    for_each_field(table, [&](const char* name, Life, auto& array) { f(name, array); });
}
/// The same for fields of one life.
template <class Table, class F>
void for_each_array_of(Life life, Table& table, F&& f) {
    for_each_field(table, [&](const char* name, Life its, auto& array) {
        if (its == life) f(name, array);
    });
}

/// The value of a new row until it is written.
template <class T>
T empty_value() {
    if constexpr (requires { T::Zero(); })
        return T::Zero();
    else
        return T{};
}

/// Sets the number of rows; new ones are zero.
template <class Table>
void resize_table(Table& table, std::size_t rows) {
    for_each_array(table, [&]<class T>(const char*, std::vector<T>& array) { array.resize(rows, empty_value<T>()); });
}

/// Appends a row of zeros. Returns its index.
template <class Table>
Index append_row(Table& table) {
    const std::size_t row = table.size();
    resize_table(table, row + 1);
    return static_cast<Index>(row);
}

/// Keeps these rows, which ascend, and removes all others.
template <class T>
void keep_rows(std::vector<T>& array, const std::vector<Index>& rows) {
    for (std::size_t k = 0; k < rows.size(); ++k) array[k] = array[rows[k]];
    array.resize(rows.size(), empty_value<T>());
}
template <class Table>
void keep_table_rows(Table& table, const std::vector<Index>& rows) {
    for_each_array(table, [&](const char*, auto& array) { keep_rows(array, rows); });
}

/// Row k becomes the old row rows[k]. The rows may be in any order, each at most once.
template <class T>
void select_rows(std::vector<T>& array, const std::vector<Index>& rows) {
    std::vector<T> chosen(rows.size(), empty_value<T>());
    for (std::size_t k = 0; k < rows.size(); ++k) chosen[k] = array[rows[k]];
    array.swap(chosen);
}
template <class Table>
void select_table_rows(Table& table, const std::vector<Index>& rows) {
    for_each_array(table, [&](const char*, auto& array) { select_rows(array, rows); });
}

/// Calls f(array of a, array of b) for all arrays of two tables of the same type.
template <class Table, class F>
void for_each_pair(Table& a, const Table& b, F&& f) {
    std::vector<const void*> other;
    for_each_array(b, [&](const char*, const auto& array) { other.push_back(&array); });
    std::size_t k = 0;
    for_each_array(a, [&]<class T>(const char*, std::vector<T>& array) {
        f(array, *static_cast<const std::vector<T>*>(other[k++]));
    });
}

/// Scratch for one array. It is kept, so that reordering allocates nothing.
using ReorderScratch = std::vector<Vec3>;

/// New row k becomes the old row order[k]; order is a permutation of all rows.
template <class Table>
void reorder_table(Table& table, const std::vector<Index>& order, ReorderScratch& scratch) {
    constexpr std::size_t kGrain = 4096;
    const std::size_t n = order.size();
    scratch.resize(n, Vec3::Zero());
    for_each_array(table, [&]<class T>(const char*, std::vector<T>& array) {
        if constexpr (std::is_same_v<T, Vec3>) {
            parallel_for(
                n, [&](std::size_t k) { scratch[k] = array[order[k]]; }, kGrain);
            array.swap(scratch);
        } else if constexpr (sizeof(T) <= sizeof(Vec3) && std::is_trivially_copyable_v<T>) {
            auto* sorted = reinterpret_cast<std::byte*>(scratch.data());
            parallel_for(
                n, [&](std::size_t k) { std::memcpy(sorted + k * sizeof(T), &array[order[k]], sizeof(T)); }, kGrain);
            parallel_for(
                n,
                [&](std::size_t k) { std::memcpy(static_cast<void*>(&array[k]), sorted + k * sizeof(T), sizeof(T)); },
                kGrain);
        } else {
            std::vector<T> sorted(n, empty_value<T>());
            parallel_for(
                n, [&](std::size_t k) { sorted[k] = array[order[k]]; }, kGrain);
            array.swap(sorted);
        }
    });
}

/// The index of each old row after select_table_rows with the same list; kNone where the row is gone.
inline std::vector<Index> new_places(const std::vector<Index>& rows, std::size_t before) {
    std::vector<Index> place(before, kNone);
    for (std::size_t k = 0; k < rows.size(); ++k) place[rows[k]] = static_cast<Index>(k);
    return place;
}

}  // namespace thixo
