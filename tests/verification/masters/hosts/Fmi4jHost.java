import java.io.File;
import java.io.PrintWriter;
import java.nio.file.Files;
import java.nio.file.Path;
import java.util.List;
import java.util.StringJoiner;
import no.ntnu.ihb.fmi4j.Fmi4jVariableUtils;
import no.ntnu.ihb.fmi4j.FmiStatus;
import no.ntnu.ihb.fmi4j.SlaveInstance;
import no.ntnu.ihb.fmi4j.importer.fmi2.Fmu;

/** Plays one scene in FMI4j; arguments: job.py. */
public final class Fmi4jHost {
    private static void insist(boolean good, String what) {
        if (!good) {
            throw new IllegalStateException(what + " was refused");
        }
    }

    private static void write(SlaveInstance cam, String name, String value) {
        FmiStatus status = switch (cam.getModelVariables().getByName(name).getType()) {
            case REAL -> Fmi4jVariableUtils.writeReal(cam, name, Double.parseDouble(value));
            case INTEGER -> Fmi4jVariableUtils.writeInteger(cam, name, Integer.parseInt(value));
            case STRING -> Fmi4jVariableUtils.writeString(cam, name, value);
            default -> throw new IllegalArgumentException(name);
        };
        insist(status == FmiStatus.OK, name);
    }

    /** A row of the inputs, without its time. */
    private static void write(SlaveInstance cam, String[] names, String row) {
        String[] values = row.split(",");
        for (int i = 1; i < names.length; i++) {
            write(cam, names[i], values[i]);
        }
    }

    private static String read(SlaveInstance cam, String[] names) {
        StringJoiner line = new StringJoiner(",");
        for (String name : names) {
            var read = Fmi4jVariableUtils.read(cam.getModelVariables().getByName(name), cam);
            insist(read.getStatus() == FmiStatus.OK, name);
            line.add(read.getValue().toString());
        }
        return line.toString();
    }

    public static void main(String[] arguments) throws Exception {
        double step = Double.parseDouble(arguments[1]);
        List<String> inputs = Files.readAllLines(Path.of(arguments[2]));
        String[] names = inputs.get(0).split(",");
        String[] outputs = arguments[4].split(",");
        try (Fmu fmu = Fmu.from(new File(arguments[0]));
                SlaveInstance cam = fmu.asCoSimulationFmu().newInstance("cam");
                PrintWriter file = new PrintWriter(arguments[3])) {
            insist(cam.setupExperiment(0.0, 0.0, 0.0), "setupExperiment");
            for (int i = 5; i < arguments.length; i++) {
                String[] start = arguments[i].split("=", 2);
                write(cam, start[0], start[1]);
            }
            write(cam, names, inputs.get(1));
            insist(cam.enterInitializationMode(), "enterInitializationMode");
            insist(cam.exitInitializationMode(), "exitInitializationMode");
            file.println(arguments[4]);
            file.println(read(cam, outputs));
            for (int k = 1; k + 1 < inputs.size(); k++) {
                write(cam, names, inputs.get(k));
                insist(cam.doStep((k - 1) * step, step), "doStep");
                file.println(read(cam, outputs));
            }
            insist(cam.terminate(), "terminate");
        }
    }
}
