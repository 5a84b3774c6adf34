#include "tools/second_opinion/second_opinion.h"

#include "tools/program/options.h"
#include "tools/robot/robot_text.h"
#include "tools/text/csv.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace proximity_server::tools {
namespace {

constexpr std::size_t kPairsInBlock = 20000;  // so many are asked in one child process
constexpr int kLimit = 10;                    // [s] of processor time for one pair

const char* toText(ChildEnd end) {
  switch (end) {
    case ChildEnd::Answered:
      return "";
    case ChildEnd::Threw:
      return "threw";
    case ChildEnd::Aborted:
      return "aborted";
    case ChildEnd::Endless:
      return "did not end";
  }
  return "";
}

std::string otherText(const OtherOpinion& other, double padding) {
  if (other.end != ChildEnd::Answered) return toText(other.end);
  return other.answer.kind == OtherAnswer::Kind::Overlap ? "overlap" : shortest(other.answer.distance - padding);
}

bool isListed(Ruling ruling) { return ruling != Ruling::Agrees && ruling != Ruling::NotAsked; }

}  // namespace

void declareSecondOpinion(ProgramOptions& program, SecondOpinionOptions& options) {
  const auto read = [](const std::string& name) {
    if (name != "fcl") throw std::invalid_argument("'" + name + "' is not fcl");
    if (!makeFcl()) throw std::invalid_argument("this build has no FCL");
    return true;
  };
  program.addRead("--second-opinion", "LIBRARY", options.is_wanted, read,
                  "fcl: ask FCL about the pairs that are listed too, and prove who is right where the two differ; exit "
                  "code 3 if ours is refuted");
  addLength(program, "--second-opinion-tolerance", options.tolerance, 0.0,
            "what counts as a difference (default: 1e-5)")
      .needs = "--second-opinion";
  program.addOutput("--second-opinion-out", "FILE", options.out, "where the pairs that differ are listed (CSV)").needs =
      "--second-opinion";
}

SecondOpinion::SecondOpinion(const SecondOpinionOptions& options, std::shared_ptr<const scene::SceneModel> model)
    : options_(options), model_(std::move(model)) {
  if (options_.out.empty()) return;
  list_.emplace(options_.out);
  list_->append("state,link_a,link_b,ours,lower,upper,fcl,proven_lower,proven_upper,verdict\n");
}

void SecondOpinion::add(long state, const std::vector<scene::PairProximity>& pairs, const scene::Positions& positions,
                        std::shared_ptr<const scene::Objects> objects) {
  block_.push_back({state, {}, scene::forwardKinematics(model_->robot, positions), std::move(objects)});
  for (const scene::PairProximity& pair : pairs)
    if (pair.result.status != narrowphase::Status::Unknown) block_.back().pairs.push_back(pair);
  pairs_in_block_ += block_.back().pairs.size() + 1;  // a state without pairs takes room too
  if (pairs_in_block_ >= kPairsInBlock) askBlock();
}

void SecondOpinion::end() {
  askBlock();
  if (list_) list_->flush();
}

void SecondOpinion::complete() {
  if (list_) list_->complete();
}

std::vector<SecondOpinion::PendingPair> SecondOpinion::pendingPairs() const {
  std::vector<PendingPair> pending;
  for (const PendingState& state : block_)
    for (const scene::PairProximity& pair : state.pairs) pending.push_back({state, pair});
  return pending;
}

void SecondOpinion::askBlock() {
  const std::vector<PendingPair> pending = pendingPairs();
  std::vector<OtherAnswer> answers(pending.size());
  AskOther fcl;  // made in each child
  const std::vector<ChildEnd> ends = askInChildren<OtherAnswer>(
      answers,
      [&](std::size_t question, OtherAnswer& answer) {
        if (!fcl) fcl = makeFcl();
        const auto& [state, pair] = pending[question];
        answer = fcl(piecesOf(pair.asked.a, state), piecesOf(pair.asked.b, state));
      },
      kLimit);
  for (std::size_t i = 0; i < pending.size(); ++i) judgePair(pending[i], {ends[i], answers[i]});
  block_.clear();
  pairs_in_block_ = 0;
}

void SecondOpinion::judgePair(const PendingPair& pending, const OtherOpinion& other) {
  const PlacedPieces a = piecesOf(pending.pair.asked.a, pending.state),
                     b = piecesOf(pending.pair.asked.b, pending.state);
  const narrowphase::SignedDistance& ours = pending.pair.result;
  const double padding = paddingOf(pending.pair.asked);
  const Judgement judgement = judge({a, b, padding, ours, other}, options_.tolerance);
  ++counts_[static_cast<std::size_t>(judgement.ruling)];
  if (!isListed(judgement.ruling)) return;
  const std::string row = rowOf(pending, other, judgement);
  if (list_) list_->append(row + '\n');
  if (judgement.ruling == Ruling::Inside) return;  // a difference, and nobody's error
  const bool is_number = other.end == ChildEnd::Answered && other.answer.kind == OtherAnswer::Kind::Distance;
  const double difference = is_number ? std::abs(other.answer.distance - padding - ours.distance) : 0.0;
  const bool is_worse = judgement.ruling == Ruling::OursRefuted || difference > worst_difference_;
  if (!worst_.empty() && !is_worse) return;
  worst_difference_ = judgement.ruling == Ruling::OursRefuted ? std::numeric_limits<double>::infinity() : difference;
  worst_ = sentenceOf(pending, other, judgement);
}

PlacedPieces SecondOpinion::piecesOf(const scene::ShapeRef& ref, const PendingState& state) const {
  return placedPieces(ref, model_->robot, state.objects.get(), state.poses);
}

/// [m] see LinkPair::padding
double SecondOpinion::paddingOf(const scene::ShapeRefPair& pair) const {
  if (!pair.areLinks()) return 0.0;
  const int index = model_->pairs.find(pair.a.link(), pair.b.link());
  return index < 0 ? 0.0 : model_->pairs.pairs[index].padding;
}

std::string SecondOpinion::rowOf(const PendingPair& pending, const OtherOpinion& other,
                                 const Judgement& judgement) const {
  const auto& [state, pair] = pending;
  const bool is_judged = judgement.ruling != Ruling::Failed;
  std::string row = std::to_string(state.number);
  for (const scene::ShapeRef& ref : {pair.asked.a, pair.asked.b})
    row += "," + csvField(nameOf(ref, model_->robot, state.objects.get()));
  for (const double number : {pair.result.distance, pair.result.lower_bound, pair.result.upper_bound})
    row += "," + shortest(number);
  row += "," + otherText(other, paddingOf(pair.asked));
  for (const double bound : {judgement.proven.lower, judgement.proven.upper})
    row += "," + (is_judged ? shortest(bound) : "");
  return row + "," + csvField(toString(judgement.ruling));
}

std::string SecondOpinion::sentenceOf(const PendingPair& pending, const OtherOpinion& other,
                                      const Judgement& judgement) const {
  const auto& [state, pair] = pending;
  const auto name = [&, objects = state.objects.get()](const scene::ShapeRef& ref) {
    return nameOf(ref, model_->robot, objects);
  };
  std::string text = "state " + std::to_string(state.number) + ", " + name(pair.asked.a) + " - " + name(pair.asked.b) +
                     ": ours " + shortest(pair.result.distance) + ", FCL " + otherText(other, paddingOf(pair.asked));
  if (judgement.ruling != Ruling::Failed)
    text += ", proven " + shortest(judgement.proven.lower) + " to " + shortest(judgement.proven.upper);
  return text + ": " + toString(judgement.ruling);
}

std::string SecondOpinion::summary() const {
  long asked = -countOf(Ruling::NotAsked);
  for (const long count : counts_) asked += count;
  const long wrong = countOf(Ruling::BelowLower) + countOf(Ruling::AboveUpper);
  std::string text = "FCL was asked about " + std::to_string(asked) +
                     " pairs: " + std::to_string(countOf(Ruling::Agrees)) + " agree within " +
                     shortest(options_.tolerance) + " m, FCL is proven wrong about " + std::to_string(wrong) +
                     " and failed on " + std::to_string(countOf(Ruling::Failed)) + ", ours is refuted for " +
                     std::to_string(countOf(Ruling::OursRefuted)) + ", " + std::to_string(countOf(Ruling::Undecided)) +
                     " are undecided";
  if (const long inside = countOf(Ruling::Inside))
    text += ", " + std::to_string(inside) + " are inside of a closed mesh";
  if (const long without = countOf(Ruling::NotAsked)) text += "; it has no shape for " + std::to_string(without);
  return worst_.empty() ? text + "." : text + ".\n  the worst: " + worst_;
}

}  // namespace proximity_server::tools
