#pragma once

#include <cstddef>
#include <exception>
#include <functional>
#include <vector>

namespace proximity_server::system {

/// The threads of a pipeline. The calling thread is one of them, and has the number 0.
struct PipelineThreads {
  /// The reaction if the system refuses to start a thread. Refused: an error that asks for fewer with --threads.
  /// Enough: continue with the threads that there are.
  enum class TooFew : unsigned char { Refused, Enough };

  int count = 1;  ///< the largest number; each thread is started when there is a block for it
  TooFew too_few = TooFew::Refused;
  /// the number of blocks for each thread that are read but not yet written; with 4, a slow block does not stop the
  /// others
  int blocks = 4;
};

/// The three steps of a pipeline.
template <typename Block>
struct PipelineSteps {
  std::function<bool(Block&)> read;  ///< fills the next block; returns false at the end. One call at a time
  /// several calls at a time; threads may keep what they need for the next
  std::function<void(Block&, int thread)> work;
  std::function<void(Block&)> write = nullptr;  ///< one call at a time, in the order of reading; may be empty
};

/// Runs a pipeline of blocks that have numbers from 0 to `blocks` - 1.
void runPipeline(const PipelineSteps<const std::size_t>& steps, std::size_t blocks, const PipelineThreads& threads);

/// Reads, works on and writes a sequence of blocks in several threads. Each thread reads the next block, works on it,
/// and then writes all blocks whose turn has come. Blocks are reused, so that their memory is allocated once, and their
/// number bounds the memory.
/// Failure: throws the error of a step; if several blocks fail, the error of the first one in their order. The blocks
///          before it are written, no other block is, and no more are read. Throws std::runtime_error if threads are
///          refused.
///
/// Own code, because TBB cannot do with fewer threads than it asks for. A wrapper around its parallel_pipeline() passes
/// pipeline_test, but with RLIMIT_NPROC = 1 TBB 2020 (Debian 11) ends the process, and oneTBB 2021 (Debian 12) throws.
template <typename Block>
void runPipeline(const PipelineSteps<Block>& steps, const PipelineThreads& threads) {
  std::vector<Block> blocks(static_cast<std::size_t>(threads.count) * static_cast<std::size_t>(threads.blocks));
  PipelineSteps<const std::size_t> numbered;
  numbered.read = [&](std::size_t i) { return steps.read(blocks[i]); };
  numbered.work = [&](std::size_t i, int thread) { steps.work(blocks[i], thread); };
  if (steps.write) numbered.write = [&](std::size_t i) { steps.write(blocks[i]); };
  runPipeline(numbered, blocks.size(), threads);
}

/// A sequence of items that are answered in blocks. The answers about a block do not depend on other blocks, so they
/// have the same bits for any number of threads; warm starts that are kept between blocks would change the last digits.
template <typename Item, typename Answer>
struct ItemsInBlocks {
  std::size_t block_size = 1;
  std::function<bool(Item&)> next;                                      ///< reads one item; false at the end
  std::function<std::vector<Answer>(const std::vector<Item>&)> answer;  ///< answers one block
  std::function<void(const Answer&)> handle;                            ///< receives the answers in order
};

/// Reads all items, answers them and handles the answers, as a pipeline of blocks of one size.
/// Failure: throws as runPipeline() does. An error of `next` is thrown after the answers about all items before it were
///          handled.
template <typename Item, typename Answer>
void answerInBlocks(const ItemsInBlocks<Item, Answer>& items, int threads) {
  struct Block {
    std::vector<Item> items;
    std::vector<Answer> answers;
  };
  std::exception_ptr error;
  const auto read = [&](Block& block) {
    block.items.clear();
    try {
      for (Item item; block.items.size() < items.block_size && !error && items.next(item);) block.items.push_back(item);
    } catch (...) {
      error = std::current_exception();
    }
    return !block.items.empty();
  };
  const auto work = [&](Block& block, int) { block.answers = items.answer(block.items); };
  const auto write = [&](Block& block) {
    for (const Answer& answer : block.answers) items.handle(answer);
  };
  constexpr int kBlocks = 1;  // one is enough, because lists of all pairs are large
  runPipeline<Block>({read, work, write}, {threads, PipelineThreads::TooFew::Refused, kBlocks});
  if (error) std::rethrow_exception(error);
}

}  // namespace proximity_server::system
