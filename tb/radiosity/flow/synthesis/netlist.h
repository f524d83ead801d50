// A netlist for the ECP5, cell by cell: what tb/radiosity/flow/synthesis/netlist.py writes into `Vtop.h` as a program is carried out.

#pragma once

#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <vector>

// As of Verilator, so that tb/system/machine.cpp takes the netlist for what Verilator makes.
using CData = uint8_t;
using SData = uint16_t;
using IData = uint32_t;
using QData = uint64_t;
struct VerilatedContext {};

class Netlist {
public:
    explicit Netlist(const char* path) {
        std::ifstream file(path, std::ios::binary);
        std::vector<int32_t> words;
        for (int32_t word; file.read(reinterpret_cast<char*>(&word), sizeof word);) words.push_back(word);
        if (words.empty()) throw std::runtime_error("no program");
        const int32_t* next = words.data();
        value.resize(*next++), value[1] = 1;
        take(next, gates), take(next, registers), take(next, products), take(next, small), take(next, blocks);
        for (const Register& one : registers) value[one.q] = one.set;
    }

    std::vector<uint8_t> value;

    // All that follows from registers, memories and inputs.
    void settle() {
        for (const Gate& gate : gates) {
            const int32_t* in = gate.in;
            const int low = value[in[0]] | value[in[1]] << 1, index = low | value[in[2]] << 2 | value[in[3]] << 3;
            switch (gate.kind) {
            case 0: value[gate.out[0]] = gate.init >> index & 1; break;
            case 1: value[gate.out[0]] = value[in[value[in[2]]]]; break;
            case 2: {
                const int table = gate.init >> index & 1, carry = value[in[4]], injects = gate.init >> 16;
                value[gate.out[0]] = table ^ (injects ? 0 : carry);
                value[gate.out[1]] = table ? carry : injects ? 0 : gate.init >> low & 1;
                break;
            }
            default: value[gate.out[0]] = small[gate.init >> 2].words[index] >> (gate.init & 3) & 1;
            }
        }
    }

    // A rising edge of the clock, after `settle`.
    void rise() {
        for (Register& one : registers)
            one.next = value[one.reset] ? one.set : value[value[one.enable] != one.inverts ? one.data : one.q];
        for (Product& one : products) one.rise(value);
        for (Small& one : small)
            if (value[one.enable]) one.words[number(one.address, 4)] = number(one.data, 4);
        for (Block& one : blocks) one.rise(*this);
        for (const Register& one : registers) value[one.q] = one.next;
        for (const Product& one : products) give(one.p, 36, one.held);
        for (const Block& one : blocks) {
            const bool wide = one.ports[1].width == 36;
            const uint64_t b = one.ports[1].given();
            give(one.ports[0].out, 18, wide ? b : one.ports[0].given());
            give(one.ports[1].out, 18, wide ? b >> 18 : b);
        }
    }

    uint64_t number(const int32_t* bits, int count) const {
        uint64_t result = 0;
        for (int k = 0; k < count; ++k) result |= uint64_t(value[bits[k]]) << k;
        return result;
    }

    void give(const int32_t* bits, int count, uint64_t number) {
        for (int k = 0; k < count; ++k)
            if (bits[k] > 1) value[bits[k]] = number >> k & 1;
    }

private:
    struct Gate { int32_t kind, init, in[5], out[2]; };
    struct Register { int32_t data, enable, inverts, reset, q, set, next; };

    struct Product {
        int32_t a[18], b[18], signed_a, signed_b, enable, reset, holds, p[36];
        int64_t x, y, held;

        static int64_t operand(const std::vector<uint8_t>& value, const int32_t* bits, bool is_signed) {
            int64_t result = 0;
            for (int k = 0; k < 18; ++k) result |= int64_t(value[bits[k]]) << k;
            return is_signed && result >> 17 ? result - (1 << 18) : result;
        }

        void rise(const std::vector<uint8_t>& value) {
            const int64_t left = operand(value, a, value[signed_a]), right = operand(value, b, value[signed_b]);
            if (value[reset]) x = y = held = 0;
            else if (value[enable]) held = holds ? x * y : left * right, x = left, y = right;
        }
    };

    struct Small { int32_t data[4], address[4], enable, words[16]; };

    // As `DP16KD` of cells.v.
    struct Port {
        int32_t width, holds, writes, data[18], address[14], enable, held_enable, write, reset, out[18];
        int64_t read, held;

        int64_t given() const { return holds ? held : read; }

        int first(int at) const {
            return width == 36 ? 0 : (at >> 4 & 1) * 18 + (width == 18 ? 0 : (at >> 3 & 1) * 9 + (
                width == 9 ? 0 : width == 4 ? (at >> 2 & 1) * 4 : width == 2 ? (at >> 1 & 3) * 2 : at & 7));
        }

        uint64_t part(int at) const { return ((1ULL << width) - 1) << first(at); }

        uint64_t bytes(int at) const {
            if (width < 18) return part(at);
            uint64_t mask = 0;
            for (int k = 0; k < width / 9; ++k) mask |= uint64_t(at >> k & 1 ? 511 : 0) << 9 * k;
            return mask << first(at);
        }
    };

    struct Block {
        Port ports[2];
        int32_t words[1024];

        void rise(const Netlist& net) {
            const auto& value = net.value;
            int at[2];
            uint64_t row[2], written[2], data[2], answer[2];
            for (int k = 0; k < 2; ++k) {
                const Port& port = ports[k];
                at[k] = net.number(port.address, 14);
                row[k] = uint32_t(words[at[k] >> 5 << 1]) | uint64_t(words[(at[k] >> 5 << 1) + 1]) << 18;
                written[k] = value[port.enable] && value[port.write] ? port.bytes(at[k]) : 0;
                data[k] = net.number(port.data, 18);
                if (k == 0 && port.width == 36) data[k] |= net.number(ports[1].data, 18) << 18;
                data[k] <<= port.first(at[k]);
            }
            const bool same = at[0] >> 5 == at[1] >> 5;
            if (same) data[1] ^= written[0] & written[1];
            for (int k = 0; k < 2; ++k) {
                Port& port = ports[k];
                const bool through = value[port.write] && port.writes == 1;
                answer[k] = through ? (row[k] & ~written[k]) | (data[k] & written[k]) : row[k];
                if (same) answer[k] ^= written[1 - k];
                if (value[port.held_enable]) port.held = port.read;
                if (value[port.reset]) port.read = 0;
                else if (value[port.enable] && (!value[port.write] || port.writes))
                    port.read = (answer[k] & port.part(at[k])) >> port.first(at[k]);
            }
            for (int k = 0; k < 2; ++k) {
                int32_t* two = words + (at[k] >> 5 << 1);
                const uint64_t before = uint32_t(two[0]) | uint64_t(two[1]) << 18;
                const uint64_t after = (before & ~written[k]) | (data[k] & written[k]);
                two[0] = after & 0x3FFFF, two[1] = after >> 18;
            }
        }
    };

    std::vector<Gate> gates;
    std::vector<Register> registers;
    std::vector<Product> products;
    std::vector<Small> small;
    std::vector<Block> blocks;

    // A count, and that many; what they hold that is no number of the program is 0.
    template <class Cell>
    static void take(const int32_t*& next, std::vector<Cell>& cells) {
        const int32_t count = *next++;
        cells.resize(count);
        for (Cell& cell : cells) read(next, cell);
    }

    static void read(const int32_t*& next, int32_t* to, size_t count) {
        while (count--) *to++ = *next++;
    }
    static void read(const int32_t*& next, Gate& cell) { read(next, &cell.kind, 9); }
    static void read(const int32_t*& next, Register& cell) { read(next, &cell.data, 6); }
    static void read(const int32_t*& next, Product& cell) {
        read(next, cell.a, 18 + 18 + 5 + 36);
        cell.x = cell.y = cell.held = 0;
    }
    static void read(const int32_t*& next, Small& cell) { read(next, cell.data, 4 + 4 + 1 + 16); }
    static void read(const int32_t*& next, Block& cell) {
        for (Port& port : cell.ports) {
            read(next, &port.width, 3 + 18 + 14 + 4 + 18);
            port.read = port.held = 0;
        }
        read(next, cell.words, 1024);
    }
};
