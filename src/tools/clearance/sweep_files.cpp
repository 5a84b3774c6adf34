#include "tools/clearance/sweep_files.h"

#include "system/whole_file.h"
#include "tools/clearance/clearance_rows.h"
#include "tools/clearance/state_sweep.h"
#include "tools/robot/robot_text.h"
#include "tools/sweep/digests.h"
#include "tools/sweep/sweep_folder.h"
#include "tools/sweep/sweep_manifest.h"
#include "tools/text/content_hash.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <stdexcept>
#include <utility>

namespace proximity_server::tools {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kProgram = "proximity_server " PROXIMITY_VERSION;

std::string threeDigits(double number) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.3g", number);
  return text.data();
}

Json describeModel(const scene::SceneModel& model) {
  const ModelDigest digest = digestOf(model);
  return {{"robot", model.robot.name}, {"joints", digest.joints}, {"shapes", digest.shapes}, {"pairs", digest.pairs}};
}

Json namesOf(const ClearanceQuestion& question) {
  Json names = Json::array();
  const scene::RobotModel& robot = question.model->robot;
  for (const scene::ShapeRefPair& pair : question.pairs)
    names.push_back({nameOf(pair.a, robot), nameOf(pair.b, robot)});
  return names;
}

/// Computes a range into a file, with a manifest of this sweep beside it. Returns the manifest.
SweepManifest compute(const ClearanceQuestion& question, RowFormat format, StateSource& states, const StateRange& range,
                      const std::string& path, Json sweep) {
  AnswerCounter counter("states", range.end == kToTheEnd ? totalOf(states, RowKind::State) : range.size());
  RowOutput file(path, StateRows(question, format).format());
  AnswerOutput output{format, file, counter};
  SweepManifest manifest;
  manifest.summary = sweepStates(question, states, range, output);
  counter.clear();
  manifest.range = {range.begin, range.begin + manifest.summary.states};
  manifest.sweep = std::move(sweep);
  manifest.sweep["states"]["count"] = std::max<std::uint64_t>(manifest.statesOfSweep(), manifest.range.end);
  file.end();
  file.complete();
  manifest.rows = file.rows();
  manifest.bytes = file.bytes();
  manifest.hash = file.hash();
  writeManifest(manifest, path);
  return manifest;
}

/// The format of the files of a sweep. Throws std::invalid_argument if this program does not know it.
OutputFormat formatOf(const Json& sweep) {
  const std::string name = sweep.at("output").at("format");
  const std::optional<RowFormat> format = rowFormatNamed(name);
  if (!format) throw std::invalid_argument("format \"" + name + "\": unknown");
  const Json& question = sweep.at("question");
  return stateFormat(*format, readPairSelection(question.at("pairs")), sweep.at("pairs").size(),
                     {!question.value("thresholds", Json()).is_null(), false});
}

Json hashOf(const std::string& file) { return file.empty() ? Json() : Json(contentHash(file)); }

}  // namespace

Json describe(const ClearanceQuestion& question, RowFormat format, const StateSource& states, std::uint64_t count) {
  const ObjectSchedule* const objects = question.objects.get();
  const auto& thresholds = question.thresholds;
  Json json;
  json["program"] = {{"version", kProgram}, {"digest", programDigest()}};
  json["model"] = describeModel(*question.model);
  json["question"] = {
      {"pairs", textOf(question.selection)},
      {"filter", question.filter == PairFilter::On},
      {"skipping", question.skipping == scene::Skipping::On},
      {"objects", hashOf(question.objects_file)},
      // The meshes of objects lie in files of their own.
      {"object_shapes", objects ? Json(shapesDigestOf(objects->all())) : Json()},
      {"thresholds", hashOf(question.thresholds_file)},
      // The joints of groups stand in the SRDF.
      {"thresholds_of_pairs", thresholds ? Json(digestOf(*thresholds, question.model->robot)) : Json()}};
  json["states"] = {{"identity", states.identity()}, {"count", count}};
  json["output"] = {{"format", toString(format)}, {"type", StateRows(question, format).format().npy_type}};
  json["pairs"] = namesOf(question);
  return json;
}

void computePart(const ClearanceQuestion& question, RowFormat format, const SweepOptions& options, StateSource& states,
                 const std::string& folder) {
  const std::optional<std::uint64_t> count = states.count();
  const StateRange range = rangeOf(options, count, states.header().source);
  const Json described = describe(question, format, states, *count);
  const SweepFolder parts(folder);
  const std::string path = parts.file(range, format);
  if (parts.isDone(described, range, format)) {
    std::cerr << "clearance: " << path << " is there already\n";
    return;
  }
  const std::clock_t begin = std::clock();
  const SweepManifest manifest = compute(question, format, states, range, path, described);
  std::cerr << "clearance: " << path << ": " << manifest.summary.text() << "\n  "
            << costOf(range.size(), manifest.bytes, begin) << '\n';
}

SweepManifest computeNpy(const ClearanceQuestion& question, StateSource& states, const std::string& out) {
  // Before the run, which may outlast the files that it was made of.
  Json described = describe(question, RowFormat::Npy, states, 0);
  return compute(question, RowFormat::Npy, states, {0, kToTheEnd}, out, std::move(described));
}

void mergeParts(const SweepOptions& options, const std::string& out) {
  const CompleteSweep sweep = completeSweep(options.merge);
  const OutputFormat format = formatOf(sweep.manifests.front().sweep);
  const SweepManifest whole = mergeSweep(sweep, format, out);
  if (format.rows == RowFormat::Npy) writeManifest(whole, out);
  if (!options.summary.empty()) writeSummary(whole.summary, options.summary);
  std::cerr << "clearance: " << out << ": " << whole.summary.text() << '\n';
}

std::optional<std::uint64_t> totalOf(const StateSource& states, RowKind rows) {
  if (isatty(STDERR_FILENO) == 0) return std::nullopt;
  const std::optional<std::uint64_t> count = states.count();
  return count && rows == RowKind::Segment && *count > 0 ? *count - 1 : count;
}

void writeSummary(const SweepSummary& summary, const std::string& file) {
  system::replaceFile(file, summary.toJson().dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

std::string costOf(std::uint64_t states, std::uint64_t bytes, std::clock_t begin) {
  const auto count = static_cast<double>(states);
  const double hours = static_cast<double>(std::clock() - begin) / (3600.0 * static_cast<double>(CLOCKS_PER_SEC));
  return threeDigits(count / std::max(hours, 1e-12)) + " states per core-hour, " +
         threeDigits(static_cast<double>(bytes) / std::max(count, 1.0)) + " bytes a state";
}

}  // namespace proximity_server::tools
