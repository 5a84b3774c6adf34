#include "tools/sweep/sweep_folder.h"

#include "proximity_server/scene/model/names.h"
#include "system/whole_file.h"
#include "tools/sweep/row_output.h"
#include "tools/text/content_hash.h"
#include "tools/text/output_file.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

namespace proximity_server::tools {
namespace {

namespace fs = std::filesystem;

/// Digits of a state in a file name, so that names are sorted as their ranges are.
constexpr std::size_t kDigits = 12;

std::string padded(std::uint64_t number) {
  const std::string digits = std::to_string(number);
  return std::string(kDigits - std::min(kDigits, digits.size()), '0') + digits;
}

constexpr std::size_t kMostListed = 10;  // ranges in a message

constexpr const char* kBegin = "states-";

std::string beginOfName(const StateRange& range) { return kBegin + padded(range.begin) + "-" + padded(range.end); }

/// The range in the name of a part; nullopt of another file.
std::optional<StateRange> rangeInName(const std::string& path) {
  const std::string name = fs::path(path).filename();
  const std::string begin = kBegin;
  const std::size_t suffix = name.find('.');
  if (name.compare(0, begin.size(), begin) != 0 || suffix == std::string::npos) return std::nullopt;
  const auto numbers = twoNumbers(name.substr(begin.size(), suffix - begin.size()), '-');
  return numbers ? std::optional(StateRange{numbers->first, numbers->second}) : std::nullopt;
}

bool overlap(const StateRange& a, const StateRange& b) { return std::max(a.begin, b.begin) < std::min(a.end, b.end); }

/// Throws unless a manifest is one of this sweep.
void requireSameSweep(const std::string& path, const nlohmann::ordered_json& sweep) {
  const std::string what = differences(readManifest(path).sweep, sweep);
  if (!what.empty()) throw std::invalid_argument(path + ": is of another sweep: " + what);
}

/// Throws if a file has some of the states of a range, and others too.
void requireNoOverlap(const std::string& path, const StateRange& range) {
  const std::optional<StateRange> there = rangeInName(path);
  if (there && overlap(*there, range) && !(*there == range))
    throw std::invalid_argument(path + ": has the states " + textOf(*there) + ", which overlap " + textOf(range));
}

/// Passes the rows of a file to `handle`, portion by portion. Throws unless they are what the manifest says.
void readRows(const std::string& file, const SweepManifest& manifest, const OutputFormat& format,
              const std::function<void(std::string_view)>& handle) {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(file + ": is not what its manifest says: " + what + "; remove both and run it again");
  };
  std::error_code error;
  const auto size = fs::file_size(file, error);
  if (error) throw std::invalid_argument(file + ": cannot be read" + because(error.value()));
  if (size != manifest.bytes) refuse("it should have " + std::to_string(manifest.bytes) + " bytes");
  const std::string before = format.header(manifest.rows) + (manifest.rows > 0 ? format.before_first : "");
  std::ifstream stream(file, std::ios::binary);
  std::string buffer(before.size(), '\0');
  stream.read(buffer.data(), static_cast<std::streamsize>(buffer.size()));
  if (!stream || buffer != before || size < before.size() + format.end.size()) refuse("it begins otherwise");
  ContentHash hash;
  buffer.resize(std::size_t{1} << 20);
  for (std::uint64_t left = size - before.size() - format.end.size(); left > 0;) {
    const auto portion = static_cast<std::size_t>(std::min<std::uint64_t>(left, buffer.size()));
    if (!stream.read(buffer.data(), static_cast<std::streamsize>(portion))) refuse("it cannot be read");
    hash.add(buffer.data(), portion);
    handle({buffer.data(), portion});
    left -= portion;
  }
  if (hash.text() != manifest.hash) refuse("its rows have another hash");
}

}  // namespace

SweepFolder::SweepFolder(std::string path) : path_(std::move(path)) {
  std::error_code error;
  fs::create_directories(path_, error);
  if (!fs::is_directory(path_)) {
    throw std::invalid_argument(path_ + (fs::exists(path_) ? ": is a file, and parts of a sweep need a folder"
                                                           : ": cannot be made (" + error.message() + ")"));
  }
}

std::string SweepFolder::file(const StateRange& range, RowFormat format) const {
  return fs::path(path_) / (beginOfName(range) + "." + toString(format));
}

bool SweepFolder::isDone(const nlohmann::ordered_json& sweep, const StateRange& range, RowFormat format) const {
  const std::string path = file(range, format);
  // One of the others is enough: all were compared with one when they were made, and completeSweep() compares them all.
  const std::vector<std::string> others = manifestsIn(path_);
  if (!others.empty()) requireSameSweep(others.front(), sweep);
  if (fs::exists(manifestPath(path))) requireSameSweep(manifestPath(path), sweep);
  for (const std::string& other : others) requireNoOverlap(other, range);
  system::removeLeftOvers(path_, beginOfName(range) + ".");
  std::error_code error;
  if (!fs::exists(manifestPath(path))) return false;
  const SweepManifest manifest = readManifest(manifestPath(path));
  return manifest.range == range && fs::file_size(path, error) == manifest.bytes && !error;
}

std::vector<std::string> manifestsIn(const std::string& folder) {
  std::vector<std::string> paths;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error))
    if (entry.path().extension() == ".manifest" && rangeInName(entry.path())) paths.push_back(entry.path());
  if (error) throw std::invalid_argument(folder + ": cannot be read (" + error.message() + ")");
  std::sort(paths.begin(), paths.end());
  return paths;
}

CompleteSweep completeSweep(const std::string& folder) {
  std::vector<std::pair<SweepManifest, std::string>> parts;
  for (const std::string& path : manifestsIn(folder)) {
    SweepManifest manifest = readManifest(path);
    const std::string what = parts.empty() ? "" : differences(parts.front().first.sweep, manifest.sweep);
    if (!what.empty())
      throw std::invalid_argument(path + ": is of another sweep than " + manifestPath(parts.front().second) + ": " +
                                  what);
    parts.emplace_back(std::move(manifest), fs::path(path).replace_extension());
    for (const std::string& input : {path, parts.back().second})
      system::FileRoles::ofProcess().addInput("the part", input);
  }
  if (parts.empty()) throw std::invalid_argument(folder + ": has no complete part of a sweep");
  std::sort(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
    return std::pair(a.first.range.begin, a.first.range.end) < std::pair(b.first.range.begin, b.first.range.end);
  });
  CompleteSweep sweep;
  std::vector<std::string> missing;
  std::uint64_t next = 0;
  for (auto& [manifest, file] : parts) {
    if (manifest.range.begin < next)
      throw std::invalid_argument(file + ": has states that " + sweep.files.back() + " has too");
    if (manifest.range.begin > next) missing.push_back(textOf({next, manifest.range.begin}));
    next = manifest.range.end;
    sweep.files.push_back(file);
    sweep.manifests.push_back(std::move(manifest));
  }
  const std::uint64_t count = sweep.manifests.front().statesOfSweep();
  if (next < count) missing.push_back(textOf({next, count}));
  if (!missing.empty())
    throw std::invalid_argument(folder + ": the states " + scene::listed(missing, kMostListed) +
                                " of 0:" + std::to_string(count) + " are missing");
  return sweep;
}

SweepManifest mergeSweep(const CompleteSweep& sweep, const OutputFormat& format, const std::string& out) {
  SweepManifest whole = sweep.manifests.front();
  RowOutput file(out, format);
  whole.summary = {};
  whole.summary.kind = sweep.manifests.front().summary.kind;
  for (std::size_t i = 0; i < sweep.files.size(); ++i) {
    const SweepManifest& part = sweep.manifests[i];
    file.beginRows(part.rows);
    readRows(sweep.files[i], part, format, [&](std::string_view bytes) { file.append(bytes); });
    whole.summary.add(part.summary);
  }
  whole.range = {0, whole.statesOfSweep()};
  file.end();
  file.complete();
  whole.rows = file.rows();
  whole.bytes = file.bytes();
  whole.hash = file.hash();
  return whole;
}

}  // namespace proximity_server::tools
