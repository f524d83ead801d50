// The hard cells of a netlist for the ECP5, of which Yosys has no simulation models: pins and parameters as in its
// cells_bb.v and cells_sim.v. What they do is what Lattice's guides say (FPGA-TN-02204 of memories, FPGA-TN-02205 of
// multipliers), and of words of 36 bits what Yosys' brams_map_16kd.v takes for granted. Only what the netlists have is
// here: any other value of a parameter instantiates a module `not_modelled`, which there is not.

// A product, signed or not, with registers at both operands or at none, and at the product or not.
module MULT18X18D(
    input A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0,
    input B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0,
    input C17, C16, C15, C14, C13, C12, C11, C10, C9, C8, C7, C6, C5, C4, C3, C2, C1, C0,
    input SIGNEDA, SIGNEDB, SOURCEA, SOURCEB, CLK0, CE0, RST0,
    output P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18, P17, P16, P15, P14,
    P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0
);
    parameter REG_INPUTA_CLK = "NONE";
    parameter REG_INPUTB_CLK = "NONE";
    parameter REG_PIPELINE_CLK = "NONE";
    parameter REG_OUTPUT_CLK = "NONE";
    localparam HOLDS_OPERANDS = REG_INPUTA_CLK == "CLK0";
    localparam HOLDS_PRODUCT = REG_OUTPUT_CLK == "CLK0";
    generate
        if (REG_PIPELINE_CLK != "NONE" || (REG_INPUTA_CLK != "NONE" && REG_INPUTA_CLK != "CLK0")
            || (REG_INPUTB_CLK == "CLK0") != HOLDS_OPERANDS
            || (REG_OUTPUT_CLK != "NONE" && REG_OUTPUT_CLK != "CLK0")) not_modelled other_registers();
    endgenerate

    wire [17:0] a = {A17, A16, A15, A14, A13, A12, A11, A10, A9, A8, A7, A6, A5, A4, A3, A2, A1, A0};
    wire [17:0] b = {B17, B16, B15, B14, B13, B12, B11, B10, B9, B8, B7, B6, B5, B4, B3, B2, B1, B0};
    // A bit more each: whether it is signed says what it is.
    wire [18:0] wide_a = {SIGNEDA & a[17], a}, wide_b = {SIGNEDB & b[17], b};
    reg [18:0] held_a = 0, held_b = 0;
    wire signed [18:0] x = HOLDS_OPERANDS ? held_a : wide_a, y = HOLDS_OPERANDS ? held_b : wide_b;
    wire signed [37:0] product = x * y;
    reg [35:0] held = 0;
    generate
        if (HOLDS_OPERANDS || HOLDS_PRODUCT)
            always @(posedge CLK0)
                if (RST0) begin
                    held_a <= 0;
                    held_b <= 0;
                    held <= 0;
                end else if (CE0) begin
                    held_a <= wide_a;
                    held_b <= wide_b;
                    held <= product[35:0];
                end
    endgenerate
    assign {P35, P34, P33, P32, P31, P30, P29, P28, P27, P26, P25, P24, P23, P22, P21, P20, P19, P18, P17, P16, P15,
    P14, P13, P12, P11, P10, P9, P8, P7, P6, P5, P4, P3, P2, P1, P0} = HOLDS_PRODUCT ? held : product[35:0];
endmodule

// 18 kbit with two ports at one clock. What a port reads of a byte that the other one writes in the same cycle is not
// defined: here it is wrong, and so is what is in the memory if both write to it.
module DP16KD(
    input DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4, DIA3, DIA2, DIA1,
    DIA0,
    input ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0,
    input CEA, OCEA, CLKA, WEA, RSTA, CSA2, CSA1, CSA0,
    output DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2, DOA1,
    DOA0,
    input DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4, DIB3, DIB2, DIB1,
    DIB0,
    input ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0,
    input CEB, OCEB, CLKB, WEB, RSTB, CSB2, CSB1, CSB0,
    output DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2, DOB1,
    DOB0
);
    parameter DATA_WIDTH_A = 18;
    parameter DATA_WIDTH_B = 18;
    parameter REGMODE_A = "NOREG";
    parameter REGMODE_B = "NOREG";
    parameter RESETMODE = "SYNC";
    parameter ASYNC_RESET_RELEASE = "SYNC";
    parameter CSDECODE_A = "0b000";
    parameter CSDECODE_B = "0b000";
    parameter WRITEMODE_A = "NORMAL";
    parameter WRITEMODE_B = "NORMAL";
    parameter CLKAMUX = "CLKA";
    parameter CLKBMUX = "CLKB";
    parameter GSR = "ENABLED";
    parameter [319:0] INITVAL_00 = 0;
    parameter [319:0] INITVAL_01 = 0;
    parameter [319:0] INITVAL_02 = 0;
    parameter [319:0] INITVAL_03 = 0;
    parameter [319:0] INITVAL_04 = 0;
    parameter [319:0] INITVAL_05 = 0;
    parameter [319:0] INITVAL_06 = 0;
    parameter [319:0] INITVAL_07 = 0;
    parameter [319:0] INITVAL_08 = 0;
    parameter [319:0] INITVAL_09 = 0;
    parameter [319:0] INITVAL_0A = 0;
    parameter [319:0] INITVAL_0B = 0;
    parameter [319:0] INITVAL_0C = 0;
    parameter [319:0] INITVAL_0D = 0;
    parameter [319:0] INITVAL_0E = 0;
    parameter [319:0] INITVAL_0F = 0;
    parameter [319:0] INITVAL_10 = 0;
    parameter [319:0] INITVAL_11 = 0;
    parameter [319:0] INITVAL_12 = 0;
    parameter [319:0] INITVAL_13 = 0;
    parameter [319:0] INITVAL_14 = 0;
    parameter [319:0] INITVAL_15 = 0;
    parameter [319:0] INITVAL_16 = 0;
    parameter [319:0] INITVAL_17 = 0;
    parameter [319:0] INITVAL_18 = 0;
    parameter [319:0] INITVAL_19 = 0;
    parameter [319:0] INITVAL_1A = 0;
    parameter [319:0] INITVAL_1B = 0;
    parameter [319:0] INITVAL_1C = 0;
    parameter [319:0] INITVAL_1D = 0;
    parameter [319:0] INITVAL_1E = 0;
    parameter [319:0] INITVAL_1F = 0;
    parameter [319:0] INITVAL_20 = 0;
    parameter [319:0] INITVAL_21 = 0;
    parameter [319:0] INITVAL_22 = 0;
    parameter [319:0] INITVAL_23 = 0;
    parameter [319:0] INITVAL_24 = 0;
    parameter [319:0] INITVAL_25 = 0;
    parameter [319:0] INITVAL_26 = 0;
    parameter [319:0] INITVAL_27 = 0;
    parameter [319:0] INITVAL_28 = 0;
    parameter [319:0] INITVAL_29 = 0;
    parameter [319:0] INITVAL_2A = 0;
    parameter [319:0] INITVAL_2B = 0;
    parameter [319:0] INITVAL_2C = 0;
    parameter [319:0] INITVAL_2D = 0;
    parameter [319:0] INITVAL_2E = 0;
    parameter [319:0] INITVAL_2F = 0;
    parameter [319:0] INITVAL_30 = 0;
    parameter [319:0] INITVAL_31 = 0;
    parameter [319:0] INITVAL_32 = 0;
    parameter [319:0] INITVAL_33 = 0;
    parameter [319:0] INITVAL_34 = 0;
    parameter [319:0] INITVAL_35 = 0;
    parameter [319:0] INITVAL_36 = 0;
    parameter [319:0] INITVAL_37 = 0;
    parameter [319:0] INITVAL_38 = 0;
    parameter [319:0] INITVAL_39 = 0;
    parameter [319:0] INITVAL_3A = 0;
    parameter [319:0] INITVAL_3B = 0;
    parameter [319:0] INITVAL_3C = 0;
    parameter [319:0] INITVAL_3D = 0;
    parameter [319:0] INITVAL_3E = 0;
    parameter [319:0] INITVAL_3F = 0;
    generate
        if (CSDECODE_A != "0b000" || CSDECODE_B != "0b000" || CLKAMUX != "CLKA"
            || CLKBMUX != "CLKB") not_modelled another_mode();
        if (RESETMODE == "ASYNC") always @(RSTA or RSTB) if (RSTA || RSTB) $stop;
    endgenerate

    wire [13:0] address_a = {ADA13, ADA12, ADA11, ADA10, ADA9, ADA8, ADA7, ADA6, ADA5, ADA4, ADA3, ADA2, ADA1, ADA0};
    wire [13:0] address_b = {ADB13, ADB12, ADB11, ADB10, ADB9, ADB8, ADB7, ADB6, ADB5, ADB4, ADB3, ADB2, ADB1, ADB0};
    wire [17:0] pins_a = {DIA17, DIA16, DIA15, DIA14, DIA13, DIA12, DIA11, DIA10, DIA9, DIA8, DIA7, DIA6, DIA5, DIA4,
    DIA3, DIA2, DIA1, DIA0};
    wire [17:0] pins_b = {DIB17, DIB16, DIB15, DIB14, DIB13, DIB12, DIB11, DIB10, DIB9, DIB8, DIB7, DIB6, DIB5, DIB4,
    DIB3, DIB2, DIB1, DIB0};
    wire chosen_a = {CSA2, CSA1, CSA0} == 0, chosen_b = {CSB2, CSB1, CSB0} == 0;
    wire works_a = CEA & chosen_a, works_b = CEB & chosen_b;

    // Rows of 36 bits: what is narrower is a part of one. The lowest bits of an address say which, of 18 bits and more
    // which bytes of nine are written.
    function [5:0] first(input integer width, input [4:0] low);
        case (width)
            36: first = 0;
            18: first = low[4] ? 18 : 0;
            9: first = 9 * low[4:3];
            4: first = 9 * low[4:3] + 4 * low[2];
            2: first = 9 * low[4:3] + 2 * low[2:1];
            default: first = 9 * low[4:3] + low[2:0];
        endcase
    endfunction

    function [35:0] part(input integer width, input [4:0] low);
        part = ((36'd1 << width) - 36'd1) << first(width, low);
    endfunction

    function [35:0] written(input integer width, input [4:0] low);
        case (width)
            36: written = {{9{low[3]}}, {9{low[2]}}, {9{low[1]}}, {9{low[0]}}};
            18: written = {18'd0, {9{low[1]}}, {9{low[0]}}} << first(width, low);
            default: written = part(width, low);
        endcase
    endfunction

    reg [35:0] rows [0:511];
    integer k;

    // 16 words, each in 20 bits.
    task begin_with(input integer sixteen, input [319:0] words);
        for (k = 0; k < 8; k = k + 1) rows[8 * sixteen + k] = {words[40 * k + 20 +: 18], words[40 * k +: 18]};
    endtask

    initial begin
        begin_with(0, INITVAL_00); begin_with(1, INITVAL_01); begin_with(2, INITVAL_02); begin_with(3, INITVAL_03);
        begin_with(4, INITVAL_04); begin_with(5, INITVAL_05); begin_with(6, INITVAL_06); begin_with(7, INITVAL_07);
        begin_with(8, INITVAL_08); begin_with(9, INITVAL_09); begin_with(10, INITVAL_0A); begin_with(11, INITVAL_0B);
        begin_with(12, INITVAL_0C); begin_with(13, INITVAL_0D); begin_with(14, INITVAL_0E); begin_with(15, INITVAL_0F);
        begin_with(16, INITVAL_10); begin_with(17, INITVAL_11); begin_with(18, INITVAL_12); begin_with(19, INITVAL_13);
        begin_with(20, INITVAL_14); begin_with(21, INITVAL_15); begin_with(22, INITVAL_16); begin_with(23, INITVAL_17);
        begin_with(24, INITVAL_18); begin_with(25, INITVAL_19); begin_with(26, INITVAL_1A); begin_with(27, INITVAL_1B);
        begin_with(28, INITVAL_1C); begin_with(29, INITVAL_1D); begin_with(30, INITVAL_1E); begin_with(31, INITVAL_1F);
        begin_with(32, INITVAL_20); begin_with(33, INITVAL_21); begin_with(34, INITVAL_22); begin_with(35, INITVAL_23);
        begin_with(36, INITVAL_24); begin_with(37, INITVAL_25); begin_with(38, INITVAL_26); begin_with(39, INITVAL_27);
        begin_with(40, INITVAL_28); begin_with(41, INITVAL_29); begin_with(42, INITVAL_2A); begin_with(43, INITVAL_2B);
        begin_with(44, INITVAL_2C); begin_with(45, INITVAL_2D); begin_with(46, INITVAL_2E); begin_with(47, INITVAL_2F);
        begin_with(48, INITVAL_30); begin_with(49, INITVAL_31); begin_with(50, INITVAL_32); begin_with(51, INITVAL_33);
        begin_with(52, INITVAL_34); begin_with(53, INITVAL_35); begin_with(54, INITVAL_36); begin_with(55, INITVAL_37);
        begin_with(56, INITVAL_38); begin_with(57, INITVAL_39); begin_with(58, INITVAL_3A); begin_with(59, INITVAL_3B);
        begin_with(60, INITVAL_3C); begin_with(61, INITVAL_3D); begin_with(62, INITVAL_3E); begin_with(63, INITVAL_3F);
    end

    wire same = address_a[13:5] == address_b[13:5];
    wire [35:0] part_a = part(DATA_WIDTH_A, address_a[4:0]), part_b = part(DATA_WIDTH_B, address_b[4:0]);
    wire [35:0] written_a = works_a & WEA ? written(DATA_WIDTH_A, address_a[4:0]) : 36'd0;
    wire [35:0] written_b = works_b & WEB ? written(DATA_WIDTH_B, address_b[4:0]) : 36'd0;
    wire [35:0] both = {36{same}} & written_a & written_b;
    wire [35:0] data_a = {DATA_WIDTH_A == 36 ? pins_b : 18'd0, pins_a} << first(DATA_WIDTH_A, address_a[4:0]);
    wire [35:0] data_b = {18'd0, pins_b} << first(DATA_WIDTH_B, address_b[4:0]) ^ both;
    wire [35:0] row_a = rows[address_a[13:5]], row_b = rows[address_b[13:5]];
    wire [35:0] seen_a = WEA && WRITEMODE_A == "WRITETHROUGH" ? row_a & ~written_a | data_a & written_a : row_a;
    wire [35:0] seen_b = WEB && WRITEMODE_B == "WRITETHROUGH" ? row_b & ~written_b | data_b & written_b : row_b;
    wire [35:0] wrong_a = {36{same}} & written_b, wrong_b = {36{same}} & written_a;

    reg [35:0] read_a = 0, read_b = 0, held_a = 0, held_b = 0;
    // A port that is not used has a constant for its clock.
    wire clock = CLKA | CLKB;
    always @(posedge clock) begin
        if (RSTA) read_a <= 0;
        else if (works_a && (!WEA || WRITEMODE_A != "NORMAL"))
            read_a <= ((seen_a ^ wrong_a) & part_a) >> first(DATA_WIDTH_A, address_a[4:0]);
        if (RSTB) read_b <= 0;
        else if (works_b && (!WEB || WRITEMODE_B != "NORMAL"))
            read_b <= ((seen_b ^ wrong_b) & part_b) >> first(DATA_WIDTH_B, address_b[4:0]);
        if (OCEA) held_a <= read_a;
        if (OCEB) held_b <= read_b;
        if (|written_a) rows[address_a[13:5]] = row_a & ~written_a | data_a & written_a;
        if (|written_b) rows[address_b[13:5]] = rows[address_b[13:5]] & ~written_b | data_b & written_b;
    end

    wire [35:0] given_a = REGMODE_A == "OUTREG" ? held_a : read_a, given_b = REGMODE_B == "OUTREG" ? held_b : read_b;

    assign {DOA17, DOA16, DOA15, DOA14, DOA13, DOA12, DOA11, DOA10, DOA9, DOA8, DOA7, DOA6, DOA5, DOA4, DOA3, DOA2,
    DOA1, DOA0} = DATA_WIDTH_B == 36 ? given_b[17:0] : given_a[17:0];
    assign {DOB17, DOB16, DOB15, DOB14, DOB13, DOB12, DOB11, DOB10, DOB9, DOB8, DOB7, DOB6, DOB5, DOB4, DOB3, DOB2,
    DOB1, DOB0} = DATA_WIDTH_B == 36 ? given_b[35:18] : given_b[17:0];
endmodule

// What is given to it, on the global network.
module DCCA(input CLKI, output CLKO);
    assign CLKO = CLKI;
endmodule
