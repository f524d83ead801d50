// The engine, its main memory and a manager of its registers in one program: what radiosity/flow/simulator/machine_library.py builds.

#include <cstdint>
#include <cstring>
#include <deque>
#include <vector>

#include "Vtop.h"
#include "verilated.h"
#if VM_TRACE
#include "verilated_vcd_c.h"
#endif

// Verilator writes the second of two underscores as a number.
#define AXI(pin) top.axi___05F##pin
#define HOST(pin) top.host___05F##pin

namespace {

constexpr int OKAY = 0, SLVERR = 2, DECERR = 3;

// The bytes of an AXI4 pin that is as wide as a beat.
template <class Pin>
uint8_t* bytes_of(Pin& pin) {
    return reinterpret_cast<uint8_t*>(&pin);
}

struct Burst {
    uint64_t due, address;
    unsigned id, beats;
    int response;
};

// Answers a read after `latency` cycles and up to `spread` more, at random. Replies come in order, or in any.
struct Memory {
    std::vector<uint8_t> data;
    uint64_t base = 0, latency = 1, spread = 0, shuffles = 0, state = 1;
    uint64_t read_beats = 0, written_beats = 0, outside = 0;
    // Faults: beats from bad_base on are answered with an error; no read, or no write, is answered.
    uint64_t bad_base = 0, bad_limit = 0;
    bool mute_reads = false, mute_writes = false;
    std::vector<Burst> reads;
    std::deque<Burst> writes, answers;

    uint64_t random(uint64_t below) {
        // xorshift64*
        state ^= state >> 12, state ^= state << 25, state ^= state >> 27;
        return (state * 0x2545F4914F6CDD1DULL >> 33) % below;
    }

    uint64_t due(uint64_t now) { return now + latency - 1 + (spread ? random(spread + 1) : 0); }

    int response(uint64_t address, unsigned size) {
        if (address < base || address + size > base + data.size()) return ++outside, DECERR;
        return address + size > bad_base && address < bad_limit ? SLVERR : OKAY;
    }
};

struct Machine {
    VerilatedContext context;
    Vtop top{&context};
    Memory memory;
    uint64_t now = 0;
#if VM_TRACE
    VerilatedVcdC waves;
    bool traced = false;

    // Starts with a path, and stops without one.
    void trace(const char* path) {
        // Of all models: those of separately compiled clusters exist from the first evaluation on.
        if (!traced) context.trace(&waves, 99);
        traced = true;
        waves.close();
        if (path) waves.open(path);
    }

    // Two times to a cycle: the clock rises at the even ones.
    void dump() {
        if (waves.isOpen()) waves.dump(2 * now + !top.clk);
    }

    Machine() {
        // Separately compiled clusters take the context of their thread.
        Verilated::threadContextp(&context);
        context.traceEverOn(true);
    }
#else
    void dump() {}
#endif

    static constexpr unsigned beat_bytes = BEAT_BYTES;

    // One clock cycle: memory's pins of the next cycle follow from those of this one.
    void step() {
        // In a reset the pins may be anything, before the first clock of all.
        const bool read_request = !top.rst && AXI(arvalid) && AXI(arready);
        const bool write_request = !top.rst && AXI(awvalid) && AXI(awready);
        const bool write_beat = !top.rst && AXI(wvalid) && AXI(wready);
        const bool taken = !AXI(rvalid) || AXI(rready), answered = !AXI(bvalid) || AXI(bready);
        const Burst read{0, AXI(araddr), AXI(arid), AXI(arlen) + 1U, OKAY};
        const Burst write{0, AXI(awaddr), AXI(awid), AXI(awlen) + 1U, OKAY};
        if (write_beat) store();
        top.clk = 1;
        top.eval();
        ++now;
        dump();
        if (read_request) memory.reads.push_back(read), memory.reads.back().due = memory.due(now);
        if (write_request) memory.writes.push_back(write);
        if (taken) next_beat();
        if (answered) next_answer();
        AXI(arready) = 1;
        AXI(awready) = 1;
        AXI(wready) = !memory.writes.empty();
        top.clk = 0;
        top.eval();
        dump();
    }

    void store() {
        Burst& burst = memory.writes.front();
        const int response = memory.response(burst.address, beat_bytes);
        if (response) burst.response = response;
        for (unsigned k = 0; !response && k < beat_bytes; ++k)
            if (AXI(wstrb) >> k & 1)
                memory.data[burst.address - memory.base + k] = bytes_of(AXI(wdata))[k];
        ++memory.written_beats;
        burst.address += beat_bytes;
        if (!--burst.beats) {
            burst.due = memory.due(now);
            memory.answers.push_back(burst);
            memory.writes.pop_front();
        }
    }

    void next_beat() {
        auto& reads = memory.reads;
        size_t chosen = 0, due = 0;
        const size_t candidates = memory.mute_reads || reads.empty() ? 0 : memory.shuffles ? reads.size() : 1;
        for (size_t k = 0; k < candidates; ++k)
            if (reads[k].due <= now && (due++ == 0 || memory.random(due) == 0)) chosen = k;
        AXI(rvalid) = due > 0;
        if (!due) return;
        Burst& burst = reads[chosen];
        const int response = memory.response(burst.address, beat_bytes);
        if (!response) std::memcpy(bytes_of(AXI(rdata)), &memory.data[burst.address - memory.base], beat_bytes);
        AXI(rid) = burst.id;
        AXI(rresp) = response;
        AXI(rlast) = burst.beats == 1;
        ++memory.read_beats;
        burst.address += beat_bytes;
        if (!--burst.beats) reads.erase(reads.begin() + chosen);
    }

    void next_answer() {
        auto& answers = memory.answers;
        AXI(bvalid) = !memory.mute_writes && !answers.empty() && answers.front().due <= now;
        if (!AXI(bvalid)) return;
        AXI(bid) = answers.front().id;
        AXI(bresp) = answers.front().response;
        answers.pop_front();
    }

    void reset() {
        memory.reads.clear(), memory.writes.clear(), memory.answers.clear();
        AXI(arready) = AXI(awready) = AXI(wready) = AXI(rvalid) = AXI(bvalid) = 0;
        HOST(arvalid) = HOST(awvalid) = HOST(wvalid) = 0;
        HOST(rready) = HOST(bready) = 1;
        top.rst = 1;
        for (int k = 0; k < 8; ++k) step();
        top.rst = 0;
        step();
    }

    // Until the transfer occurs: `valid` and `ready` in one cycle.
    template <class Pin>
    void hand_over(CData& valid, const Pin& ready) {
        for (bool done = false; !done;) {
            valid = 1;
            top.eval();
            done = ready;
            step();
        }
        valid = 0;
        top.eval();
    }

    int read(uint32_t address, uint32_t* value) {
        HOST(rready) = 0;
        HOST(araddr) = address;
        hand_over(HOST(arvalid), HOST(arready));
        while (!HOST(rvalid)) step();
        *value = HOST(rdata);
        const int response = HOST(rresp);
        HOST(rready) = 1;
        top.eval();
        step();
        return response;
    }

    int write(uint32_t address, uint32_t value) {
        HOST(bready) = 0;
        HOST(awaddr) = address;
        HOST(wdata) = value;
        HOST(wstrb) = 15;
        bool addressed = false, written = false;
        while (!addressed || !written) {
            HOST(awvalid) = !addressed;
            HOST(wvalid) = !written;
            top.eval();
            const bool address_transfer = HOST(awvalid) && HOST(awready);
            const bool data_transfer = HOST(wvalid) && HOST(wready);
            step();
            addressed |= address_transfer, written |= data_transfer;
        }
        HOST(awvalid) = HOST(wvalid) = 0;
        top.eval();
        while (!HOST(bvalid)) step();
        const int response = HOST(bresp);
        HOST(bready) = 1;
        top.eval();
        step();
        return response;
    }
};

}  // namespace

extern "C" {

Machine* machine_make() {
    auto* machine = new Machine;
    machine->reset();
    return machine;
}

void machine_free(Machine* machine) { delete machine; }

void machine_reset(Machine* machine) { machine->reset(); }

void machine_memory(Machine* machine, uint64_t base, uint64_t size, uint64_t latency, uint64_t spread,
                    uint64_t shuffles, uint64_t seed) {
    Memory& memory = machine->memory;
    memory.base = base, memory.latency = latency, memory.spread = spread, memory.shuffles = shuffles;
    memory.state = seed * 2 + 1;
    memory.data.resize(size);
}

// Beats of these addresses fail; reads, or writes, are not answered.
void machine_faults(Machine* machine, uint64_t base, uint64_t limit, int mute_reads, int mute_writes) {
    Memory& memory = machine->memory;
    memory.bad_base = base, memory.bad_limit = limit;
    memory.mute_reads = mute_reads, memory.mute_writes = mute_writes;
}

uint8_t* machine_data(Machine* machine) { return machine->memory.data.data(); }

void machine_run(Machine* machine, uint64_t cycles) {
    for (uint64_t k = 0; k < cycles; ++k) machine->step();
}

int machine_read(Machine* machine, uint32_t address, uint32_t* value) { return machine->read(address, value); }

int machine_write(Machine* machine, uint32_t address, uint32_t value) { return machine->write(address, value); }

#if VM_TRACE
void machine_trace(Machine* machine, const char* path) { machine->trace(path); }
#endif

// Cycles, beats read and written, and beats outside the memory.
void machine_counts(Machine* machine, uint64_t* counts) {
    counts[0] = machine->now, counts[1] = machine->memory.read_beats;
    counts[2] = machine->memory.written_beats, counts[3] = machine->memory.outside;
}
}
